"use strict";
// Plots: lines and points in a box with axes, as SVG of a size in which its text can be read.

const WIDTH = 420, HEIGHT = 250, LEFT = 64, RIGHT = 10, TOP = 10, BOTTOM = 40;
const SVG = "http://www.w3.org/2000/svg";

function element(parent, name, attributes, content) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (content !== undefined) made.textContent = content;
  parent.append(made);
  return made;
}

// Limits of all numbers, a little wider; a range without width gets one.
function limits(values) {
  const finite = values.filter((value) => value !== null);
  let low = Math.min(...finite), high = Math.max(...finite);
  if (finite.length === 0) [low, high] = [0, 1];
  const room = high > low ? 0.04 * (high - low) : 0.5 * (Math.abs(high) || 1);
  return [low - room, high + room];
}

// Round numbers between two limits, about `count` of them; whole ones where asked for.
function ticks([low, high], count, whole) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  let gap = [1, 2, 5, 10].map((part) => part * power).find((size) => size >= rough * 0.999);
  if (whole) gap = Math.max(1, Math.round(gap));
  const found = [];
  for (let k = Math.ceil(low / gap - 1e-9); k * gap <= high + 1e-9 * gap; k++) found.push(k * gap);
  return found;
}

function label(value, range) {
  const size = Math.max(...range.map(Math.abs));
  if (Math.abs(value) < 1e-9 * size) return "0";
  return size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(6)));
}

// Draws `chart` into `box`; returns what moves its cursor to a step. `range` fixes the limits of x and y.
function drawChart(box, chart, range) {
  box.replaceChildren();
  const svg = element(box, "svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `${chart.title}: ${chart.ylabel} by ${chart.xlabel}`});
  const x = range ? range.x : limits(chart.series.flatMap((line) => line.x));
  const y = range ? range.y : limits(chart.series.flatMap((line) => line.y));
  const right = WIDTH - RIGHT, bottom = HEIGHT - BOTTOM;
  const across = (value) => LEFT + (value - x[0]) / (x[1] - x[0]) * (right - LEFT);
  const down = (value) => bottom - (value - y[0]) / (y[1] - y[0]) * (bottom - TOP);
  for (const value of ticks(x, 6, chart.xlabel === "step")) {
    element(svg, "line", {x1: across(value), x2: across(value), y1: TOP, y2: bottom, class: "grid"});
    element(svg, "text", {x: across(value), y: bottom + 16, "text-anchor": "middle"}, label(value, x));
  }
  for (const value of ticks(y, 5)) {
    element(svg, "line", {x1: LEFT, x2: right, y1: down(value), y2: down(value), class: value === 0 ? "zero" : "grid"});
    element(svg, "text", {x: LEFT - 6, y: down(value) + 4, "text-anchor": "end"}, label(value, y));
  }
  element(svg, "path", {d: `M${LEFT},${TOP}V${bottom}H${right}`, class: "axis"});
  element(svg, "text", {x: (LEFT + right) / 2, y: HEIGHT - 6, "text-anchor": "middle"}, chart.xlabel);
  element(svg, "text", {x: 12, y: (TOP + bottom) / 2, transform: `rotate(-90 12 ${(TOP + bottom) / 2})`, "text-anchor": "middle"}, chart.ylabel);
  for (const line of chart.series) drawLine(svg, line, across, down);
  legend(box, chart.series);
  const cursor = element(svg, "path", {class: "cursor"});
  return (step) => cursor.setAttribute("d", cursorPath(chart, step, across, down, bottom));
}

function drawLine(svg, line, across, down) {
  const known = line.x.map((value, k) => value !== null && line.y[k] !== null);
  const at = (k) => `${across(line.x[k]).toFixed(1)},${down(line.y[k]).toFixed(1)}`;
  const path = line.x.map((_, k) => known[k] ? (k > 0 && known[k - 1] ? "L" : "M") + at(k) : "").join("");
  if (!line.marks) element(svg, "path", {d: path, fill: "none", stroke: line.colour, "stroke-width": 1.5, "stroke-dasharray": line.dash});
  line.x.forEach((_, k) => {
    if (!known[k]) return;
    const [cx, cy] = at(k).split(",");
    const dot = element(svg, "circle", {cx, cy, r: line.fills ? 3.2 : line.marks ? 4 : 2, fill: line.fills ? line.fills[k] : line.colour, stroke: line.colour});
    element(dot, "title", {}, `${line.name}: ${line.x[k]}, ${line.y[k]}`);
  });
}

// A line at the step where steps are across, else rings round the points of the step.
function cursorPath(chart, step, across, down, bottom) {
  if (chart.xlabel === "step") return `M${across(step).toFixed(1)},${TOP}V${bottom}`;
  return chart.series.map((line) => {
    const k = (line.steps || []).indexOf(step);
    if (k < 0 || line.x[k] === null || line.y[k] === null) return "";
    return `M${across(line.x[k]) - 5},${down(line.y[k])}a5,5 0 1 0 10,0a5,5 0 1 0 -10,0`;
  }).join("");
}

function legend(box, series) {
  const keys = document.createElement("ul");
  keys.className = "keys";
  for (const line of series) {
    const key = document.createElement("li");
    const sample = element(key, "svg", {viewBox: "0 0 26 10", "aria-hidden": "true"});
    element(sample, "path", {d: "M0,5H26", stroke: line.colour, "stroke-width": 2, "stroke-dasharray": line.dash});
    key.append(line.name);
    keys.append(key);
  }
  box.append(keys);
}

// The slider and what it moves.

const data = JSON.parse(document.getElementById("data").textContent);
const slider = document.getElementById("step"), play = document.getElementById("play");
const MILLISECONDS = 2500 / Math.max(data.places.length, 8) + 120;
const STATE_FILLS = {open: "#ffffff", stick: "#0072b2", slip: "#d55e00"};
const moved = data.charts.map((chart, k) => drawChart(document.getElementById(`chart-${k}`), chart));

// What `steps` (by step) has for a step: of the latest one up to it.
function latest(steps, step) {
  const before = Object.keys(steps).map(Number).filter((other) => other <= step);
  return before.length ? Math.max(...before) : Number(Object.keys(steps)[0]);
}

function showScene(step) {
  const of = latest(data.tips.steps, step);
  for (const group of document.querySelectorAll("#scene [id^='step-'], #scene [id^='tips-']")) {
    const [kind, number] = group.id.split("-");
    group.toggleAttribute("hidden", kind === "step" ? Number(number) > step : Number(number) !== of);
  }
}

function showPicture(step) {
  if (!data.pictures.length) return;
  const shown = data.pictures.findLast((picture) => picture.step <= step) || data.pictures[0];
  const image = document.getElementById("picture");
  if (image.dataset.step === String(shown.step)) return;
  image.dataset.step = shown.step;
  image.src = shown.uri;
  image.alt = `${shown.words}, step ${shown.step}`;
  document.getElementById("caption").textContent = image.alt;
}

function showTips(step) {
  const body = document.getElementById("tips-body");
  if (!body) return;
  const of = latest(data.tips.steps, step), rows = data.tips.steps[of] || [];
  document.getElementById("tips-caption").textContent = `Tips of step ${of}, before it advances`;
  body.replaceChildren(...rows.map((row) => tableRow(row, "td")));
}

function tableRow(cells, kind) {
  const row = document.createElement("tr");
  for (const cell of cells) {
    const made = document.createElement(kind);
    made.textContent = cell === null ? "–" : typeof cell === "number" ? String(Number(cell.toPrecision(4))) : cell;
    if (kind === "th") made.scope = "col";
    row.append(made);
  }
  return row;
}

// Tractions, then jumps along the chosen surface; axes are those of all steps, so that the steps can be compared.
function showContact(step) {
  const choice = document.getElementById("surface");
  if (!choice) return;
  const steps = data.contact.surfaces[choice.value], of = latest(steps, step), here = steps[of], units = data.contact.units;
  const box = document.getElementById("contact"), all = Object.values(steps);
  box.replaceChildren();
  for (const [title, names, unit] of [
    ["Tractions", ["normal_traction", "tangential_traction"], units.normal_traction],
    ["Jump of displacement", ["opening", "slip"], units.slip],
  ]) {
    const series = names.map((name, k) => ({
      name: name.replace("_", " "), colour: ["#1c2530", "#7b3294"][k], dash: k ? "5 3" : "",
      x: here.s, y: here[name], fills: here.state.map((state) => STATE_FILLS[state]),
    }));
    const range = {x: limits(all.flatMap((one) => one.s)), y: limits(all.flatMap((one) => names.flatMap((name) => one[name])))};
    const part = document.createElement("div");
    box.append(part);
    drawChart(part, {title, xlabel: `s along ${choice.value} [${units.s}], step ${of}`, ylabel: `${title.toLowerCase()} [${unit}]`, series}, range);
  }
  const words = document.createElement("p");
  words.className = "legend";
  words.textContent = "points: white open, blue stick, red slip";
  box.append(words);
}

function show() {
  const step = data.places[slider ? Number(slider.value) : 0];
  if (slider) {
    const words = `step ${step} of ${data.places[data.places.length - 1]}: ${data.words[step]}`;
    document.getElementById("now").textContent = words;
    slider.setAttribute("aria-valuetext", words);
  }
  showScene(step);
  showPicture(step);
  showContact(step);
  showTips(step);
  for (const move of moved) move(step);
}

let timer = null;
function pause() {
  clearInterval(timer);
  timer = null;
  play.textContent = "Play";
}

function start() {
  if (slider.value === slider.max) slider.value = slider.min;
  timer = setInterval(() => {
    if (slider.value === slider.max) return pause();
    slider.value = Number(slider.value) + 1;
    show();
  }, MILLISECONDS);
  play.textContent = "Pause";
  show();
}

// A picture as large as it is, in a card as wide as the page; smaller again at the next press.
const larger = document.getElementById("larger");
larger?.addEventListener("click", () => {
  const large = larger.closest(".card").classList.toggle("large");
  larger.setAttribute("aria-pressed", large);
  larger.textContent = large ? "Smaller" : "Larger";
});

// On paper nothing can be opened: the case is, and closed again afterwards if it was.
let opened = [];
window.addEventListener("beforeprint", () => {
  opened = [...document.querySelectorAll("details:not([open])")];
  for (const closed of opened) closed.open = true;
});
window.addEventListener("afterprint", () => {
  for (const details of opened) details.open = false;
});

if (slider) {
  slider.addEventListener("input", show);
  play.addEventListener("click", () => timer === null ? start() : pause());
}
if (data.tips.header) document.getElementById("tips-head")?.append(tableRow(data.tips.header, "th"));
document.getElementById("surface")?.addEventListener("change", show);
show();

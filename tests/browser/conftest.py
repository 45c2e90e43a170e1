"""Tests in a browser run where they are asked for, and then it must be there; headless Chromium by chromedriver."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if "browser" in (config.getoption("markexpr") or ""):
        return
    left_out = [item for item in items if item.get_closest_marker("browser")]
    items[:] = [item for item in items if item not in left_out]
    config.hook.pytest_deselected(items=left_out)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Chromium]:
    """A headless Chromium, without network."""
    browser = Chromium()
    try:
        yield browser
    finally:
        browser.close()


ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element's id, by the standard
KEYS = {"left": "\ue012", "right": "\ue014", "home": "\ue011", "enter": "\ue007"}
ARGUMENTS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--proxy-server=127.0.0.1:9",
)  # fmt: skip  (nothing listens there: a page gets nothing from the network)


class Chromium:
    """One window. Raises FileNotFoundError where chromium or chromedriver is missing."""

    def __init__(self) -> None:
        names = ("chromium", "chromium-browser", "google-chrome")
        binary = next((path for name in names if (path := shutil.which(name))), None)
        driver = shutil.which("chromedriver")
        if binary is None or driver is None:
            raise FileNotFoundError("chromium and chromedriver are wanted: apt-get install chromium chromium-driver")
        self._process = subprocess.Popen([driver, "--port=0"], stdout=subprocess.PIPE, text=True)
        self._root = f"http://127.0.0.1:{self._port()}/session"
        options = {"binary": binary, "args": list(ARGUMENTS)}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        session = self._post("", {"capabilities": {"alwaysMatch": wanted}})
        self._root += f"/{session['sessionId']}"

    def open(self, page: Path, width: int, height: int = 900) -> None:
        """Open a page from the disk in a window of this size, pixels."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._devtools("Emulation.setDeviceMetricsOverride", size)
        self._post("/url", {"url": page.resolve().as_uri()})

    def media(self, kind: str) -> None:
        """Show pages as on "screen" or as in "print"."""
        self._devtools("Emulation.setEmulatedMedia", {"media": kind})

    def run(self, script: str) -> Any:
        """What a script returns."""
        return self._post("/execute/sync", {"script": script, "args": []})

    def press(self, selector: str, *keys: str) -> None:
        """Give an element the focus and press keys there."""
        found = self._post("/element", {"using": "css selector", "value": selector})
        self._post(f"/element/{found[ELEMENT]}/value", {"text": "".join(KEYS.get(key, key) for key in keys)})

    def messages(self) -> list[str]:
        """What the console has said since it was asked last."""
        return [entry["message"] for entry in self._post("/se/log", {"type": "browser"})]

    def close(self) -> None:
        urllib.request.urlopen(urllib.request.Request(self._root, method="DELETE"), timeout=60).close()
        self._process.terminate()
        self._process.wait(timeout=60)
        if self._process.stdout is not None:
            self._process.stdout.close()

    def _port(self) -> int:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            match = re.search(r"started successfully on port (\d+)", line)
            if match:
                return int(match[1])
        raise OSError("chromedriver did not start")

    def _devtools(self, command: str, parameters: dict[str, Any]) -> Any:
        return self._post("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def _post(self, path: str, content: dict[str, Any]) -> Any:
        headers = {"Content-Type": "application/json"}
        request = urllib.request.Request(self._root + path, json.dumps(content).encode(), headers)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

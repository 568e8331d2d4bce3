"""A small WebDriver client over chromedriver, with Python's standard library alone."""

import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
CHROMEDRIVER = shutil.which("chromedriver")


class Browser:
    """A headless page of the given size. Use as `with Browser(1280, 900) as page:`."""

    def __init__(self, width, height, phone=False, dark=False):
        self.profile = tempfile.mkdtemp(prefix="holdfast-browser-")
        self.driver = subprocess.Popen(
            [CHROMEDRIVER, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.session = None
        port = None
        for line in self.driver.stdout:
            found = re.search(r"started successfully on port (\d+)", line)
            if found:
                port = found.group(1)
                break
        if port is None:
            self.close()
            raise RuntimeError("chromedriver did not start")
        self.root = "http://127.0.0.1:" + port
        arguments = ["--headless=new", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage",
                     f"--window-size={width},{height}", f"--user-data-dir={self.profile}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            arguments.append("--no-sandbox")  # Chromium refuses its sandbox to root
        options = {"binary": CHROMIUM, "args": arguments}
        if phone:
            options["mobileEmulation"] = {"deviceMetrics": {"width": width, "height": height, "pixelRatio": 2, "touch": True}}
        capabilities = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        try:
            answer = self._call("POST", "/session", {"capabilities": {"alwaysMatch": capabilities}}, timeout=120)
            self.session = "/session/" + answer["sessionId"]
            if not phone:
                self.cdp("Emulation.setDeviceMetricsOverride",
                         {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
            if dark:
                self.cdp("Emulation.setEmulatedMedia",
                         {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        except Exception:
            self.close()
            raise

    def _call(self, method, path, body=None, timeout=60):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.root + path, data=data, method=method,
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=timeout) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(error.read().decode()[:2000]) from None

    def call(self, method, path, body=None):
        return self._call(method, self.session + path, body)

    def cdp(self, command, parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, seconds=20):
        end = time.time() + seconds
        while time.time() < end:
            if self.run(script):
                return True
            time.sleep(0.1)
        return False

    def console(self):
        return self.call("POST", "/se/log", {"type": "browser"})

    def hover(self, x, y):
        self.call("POST", "/actions", {"actions": [{
            "type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
            "actions": [{"type": "pointerMove", "duration": 50, "x": int(x) - 8, "y": int(y)},
                        {"type": "pointerMove", "duration": 50, "x": int(x), "y": int(y)}]}]})

    def drag(self, x0, x1, y):
        self.call("POST", "/actions", {"actions": [{
            "type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
            "actions": [{"type": "pointerMove", "duration": 0, "x": int(x0), "y": int(y)},
                        {"type": "pointerDown", "button": 0},
                        {"type": "pointerMove", "duration": 100, "x": int((x0 + x1) / 2), "y": int(y)},
                        {"type": "pointerMove", "duration": 100, "x": int(x1), "y": int(y)},
                        {"type": "pointerUp", "button": 0}]}]})

    def screenshot(self, path, full=True):
        shot = self.cdp("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": full, **(
            {"clip": {"x": 0, "y": 0, "width": self.run("return document.documentElement.clientWidth"),
                      "height": self.run("return document.documentElement.scrollHeight"), "scale": 1}} if full else {})})
        with open(path, "wb") as file:
            file.write(base64.b64decode(shot["data"]))

    def close(self):
        if self.session:
            try:
                self._call("DELETE", self.session, timeout=20)
            except Exception:
                pass
        self.driver.terminate()
        try:
            self.driver.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.driver.kill()
        self.driver.stdout.close()
        shutil.rmtree(self.profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

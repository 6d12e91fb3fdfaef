"""Chromium as the tests of the pages drive it: WebDriver (JSON over HTTP) to chromedriver; standard library only."""
import base64
import json
import pathlib
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request

SKIPPED = 77
HOSTILE = "</script><img src=x onerror=alert(1)>"
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"


class Browser:
    def __init__(self, driver_path, browser_path, flags=("--disable-gpu",)):
        self.flags = list(flags)
        with socket.socket() as probe:  # a free port
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.driver = subprocess.Popen([driver_path, f"--port={self.port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.session = ""
        try:
            self.start(browser_path)
        except BaseException:
            self.driver.terminate()
            raise

    def start(self, browser_path):
        for _ in range(1200):
            try:
                self.call("GET", "/status")
                break
            except (OSError, urllib.error.URLError):
                time.sleep(0.1)
        options = {"args": ["--headless=new", "--no-sandbox", *self.flags, "--disable-dev-shm-usage", "--window-size=1280,900",
                            "--disable-background-networking", "--no-first-run"], "binary": browser_path}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        for attempt in range(3):  # a loaded machine can keep a browser from starting in the driver's time
            try:
                answer = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
                break
            except (AssertionError, OSError) as error:
                if attempt == 2 or isinstance(error, AssertionError) and "session not created" not in str(error):
                    raise
                time.sleep(2)
        self.session = "/session/" + answer["sessionId"]

    def call(self, method, path, body=None, timeout=90):
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", method=method, headers={"Content-Type": "application/json"},
                                         data=None if body is None else json.dumps(body).encode())
        try:
            with urllib.request.urlopen(request, timeout=timeout) as response:
                return json.load(response)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(f"{method} {path}: {error.read().decode()[:600]}") from None

    def post(self, path, body, timeout=90):
        return self.call("POST", self.session + path, body, timeout)

    def run(self, script, *arguments):
        return self.post("/execute/sync", {"script": script, "args": list(arguments)})

    def devtools(self, command, **parameters):
        return self.post("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def paper(self):
        """The page as PDF, on A4. WebDriver's own command gives up after 10 s, which a loaded machine needs."""
        answer = self.post("/goog/cdp/execute", {"cmd": "Page.printToPDF", "params": {"printBackground": True, "preferCSSPageSize": True}},
                           timeout=600)
        return base64.b64decode(answer["data"])

    def mouse(self, *actions):
        self.post("/actions", {"actions": [{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": list(actions)}]})

    def find(self, selector):
        return self.post("/element", {"using": "css selector", "value": selector})[ELEMENT]

    def click(self, selector):
        self.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", selector)
        self.post(f"/element/{self.find(selector)}/click", {})

    def type(self, selector, text):
        self.post(f"/element/{self.find(selector)}/value", {"text": text})

    def log(self, kind):
        return self.post("/se/log", {"type": kind})

    def close(self):
        try:
            if self.session:
                self.call("DELETE", self.session)
        finally:
            self.driver.terminate()
            self.driver.wait()


def move(x, y, duration=60):
    return {"type": "pointerMove", "duration": duration, "x": int(x), "y": int(y)}


DOWN, UP = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}


def until(words, condition, seconds=15):
    end = time.time() + seconds
    while time.time() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError("not within %d s: %s" % (seconds, words))


def check(condition, words):
    if not condition:
        raise AssertionError(words)


def silence(browser, path):
    errors = [entry["message"] for entry in browser.log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    check(not errors, f"the console says: {errors}")
    own = pathlib.Path(path).as_uri()
    for entry in browser.log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            check(url == own or url.startswith("data:"), f"a request left the page: {url}")


def programs():
    """Paths of chromedriver and Chromium; None, after a word on standard output, where one is missing."""
    browser, driver = shutil.which("chromium") or shutil.which("google-chrome"), shutil.which("chromedriver")
    if browser and driver:
        return driver, browser
    print("skipped: Chromium and chromedriver are not installed (apt-get install chromium chromium-driver)")
    return None

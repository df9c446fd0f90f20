# SPDX-License-Identifier: Apache-2.0
"""A page in headless Chromium that a test uses as a person does: with the mouse, the keyboard and files.

Chromium takes commands of the DevTools protocol from a pipe: JSON texts that end with a zero byte, read from descriptor 3 and
answered on 4. So it needs neither a port nor a library."""
import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

from browser import WEBGL, program_of

ANSWER_S = 60
FREE_DESCRIPTOR = 10  # none from here on is one of Chromium's two
BUTTONS = {"left": 1, "right": 2, "middle": 4}
CONTROL, SHIFT = 2, 8  # what a key is held with


class DrivenPage:
    """The page of a file. downloads: folder that it downloads to. The test fails at its end when the page had an error, or asked for
    anything outside."""

    def __init__(self, test, path, size_px=(1200, 900)):
        self._test, self._number, self._received, self.errors = test, 0, b"", []
        program = program_of(test)
        folder = tempfile.mkdtemp(prefix="nightmap-e2e-")
        test.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        self.downloads = os.path.join(folder, "downloads")
        os.mkdir(self.downloads)
        (commands, self._commands), (self._answers, answers) = os.pipe(), os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, FREE_DESCRIPTOR) for end in (commands, answers)]
        command = [program, "--headless", "--no-sandbox", *WEBGL, "--remote-debugging-pipe",
                   f"--user-data-dir={folder}/profile", f"--window-size={size_px[0]},{size_px[1]}", "about:blank"]  # fmt: skip
        moved = ["bash", "-c", 'exec "${@:3}" 3<&"$1" 4>&"$2"', "bash", *map(str, ends), *command]
        self._log = open(os.path.join(folder, "log"), "wb")
        self._process = subprocess.Popen(moved, pass_fds=ends, stdout=self._log, stderr=self._log)
        for end in (commands, answers, *ends):
            os.close(end)
        test.addCleanup(self._close)
        self._session = None
        [target] = [item for item in self.call("Target.getTargets")["targetInfos"] if item["type"] == "page"]
        self._session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "DOM", "Network"):
            self.call(f"{domain}.enable")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=self.downloads)
        self.call("Page.navigate", url=path.resolve().as_uri())
        self.wait("document.readyState === 'complete' && location.protocol === 'file:'")

    def call(self, method, **parameters):
        """The result of a command."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                self._test.assertNotIn("error", answer, method)
                return answer["result"]
            self._note(answer)

    def _next(self):
        while b"\0" not in self._received:
            if not select.select([self._answers], [], [], ANSWER_S)[0]:
                self._test.fail(f"Chromium does not answer within {ANSWER_S} s")
            chunk = os.read(self._answers, 1 << 16)
            if not chunk:
                self._test.fail("Chromium ended")
            self._received += chunk
        text, _, self._received = self._received.partition(b"\0")
        return json.loads(text)

    def _note(self, event):
        details = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            thrown = details["exceptionDetails"]
            self.errors.append(thrown.get("exception", {}).get("description", thrown["text"]))
        if event.get("method") == "Network.requestWillBeSent" and not details["request"]["url"].startswith(("data:", "blob:", "file:")):
            self.errors.append(f"a request of {details['request']['url'][:200]}")
        if event.get("method") == "Log.entryAdded" and details["entry"]["level"] == "error":
            self.errors.append(details["entry"]["text"])

    def _close(self):
        self._process.kill()
        self._process.wait()
        self._log.close()
        os.close(self._commands)
        os.close(self._answers)
        self._test.assertEqual(self.errors, [])

    def value(self, expression):
        """The value of an expression of JavaScript."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        self._test.assertNotIn("exceptionDetails", answer, expression)
        return answer["result"].get("value")

    def wait(self, expression, seconds=20):
        end = time.monotonic() + seconds
        while not self.value(expression):
            self._test.assertLess(time.monotonic(), end, f"does not come true: {expression}")
            time.sleep(0.05)

    def middle_of(self, selector):
        """Pixels of the middle of an element, which is scrolled into view."""
        return self.value(f"""(() => {{ const element = document.querySelector({json.dumps(selector)});
            element.scrollIntoView({{block: "nearest"}}); const box = element.getBoundingClientRect();
            return [box.x + box.width / 2, box.y + box.height / 2]; }})()""")

    def mouse(self, kind, at, button="none", held=0, modifiers=0, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button=button, buttons=held, modifiers=modifiers,
                  clickCount=int(kind != "mouseMoved"), **more)  # fmt: skip

    def press(self, at, button="left"):
        self.mouse("mouseMoved", at)
        self.mouse("mousePressed", at, button, BUTTONS[button])

    def drag(self, start, end, button="left", modifiers=0):
        """Presses a button of the mouse at one place and releases it at another."""
        self.press(start, button)
        for share in (0.3, 0.7, 1):
            at = [a + share * (b - a) for a, b in zip(start, end)]
            self.mouse("mouseMoved", at, button, BUTTONS[button], modifiers)
        self.mouse("mouseReleased", end, button)

    def click(self, selector):
        at = self.middle_of(selector)
        self.press(at)
        self.mouse("mouseReleased", at, "left")

    def key(self, key, modifiers=0):
        code = {"Delete": 46, "Escape": 27, "Tab": 9, "Enter": 13, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39}.get(key) or ord(key.upper())
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, modifiers=modifiers)

    def type_into(self, selector, text):
        """Replaces the text of a field, and leaves it."""
        self.click(selector)
        self.wait(f"document.activeElement === document.querySelector({json.dumps(selector)})")
        self.value("document.activeElement.select()")
        if text:
            self.call("Input.insertText", text=text)
        else:
            self.key("Delete")
        self.key("Tab")

    def choose_file(self, selector, path):
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(path)])

    def drop_file(self, at, path):
        data = {"items": [], "files": [str(path)], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", type=kind, x=at[0], y=at[1], data=data)

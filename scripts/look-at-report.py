#!/usr/bin/env python3
"""Looks at pages of `rtbench report` and `rtbench history` in a real browser, and fails where one is not
fit to be read.

    scripts/look-at-report.py PAGE|SITE|--planted OUT_DIR [BROWSER]

Checks, on a phone (360 and 390 pixels wide) and on a desk (1280), light and dark: the page is not wider
than the window, nothing was asked of the network, nothing was said on the console, all text stands out
from its ground at least 4.5 to 1; on a desk every table shows its verdicts without scrolling; on a
phone plots are as wide as the window and their letters at least 9 pixels high; clicks on heads sort tables.
Writes a picture of each section in each of the ways, and the page as printed (A4) as a PDF. Of a
SITE (a folder) it looks at the index and at a page of each depth and kind, 8 at most, and follows every
link within the site to a page and a place that are there. Needs Python and Chromium only: it speaks the
DevTools protocol through a pipe. `--planted` looks at pages that have a fault each, and fails where it is not found.
"""
import base64, glob, json, os, re, subprocess, sys, tempfile, urllib.parse

WAYS = [("small-phone", 360, 800, 2), ("phone", 390, 844, 2), ("desk", 1280, 900, 1)]
TALLEST = 4000  # pixels of a picture
PAGES = 8  # of a site

# what is folded is looked at, too
OPEN = "document.querySelectorAll('details').forEach(d => d.open = true)"

VERDICTS = """
[...document.querySelectorAll('th')].filter(th => th.textContent === 'verdict')
  .map(th => th.getBoundingClientRect().right).filter(right => right > innerWidth)
"""

SMALL_LETTERS = """
(() => {
  const bad = {};
  for (const svg of document.querySelectorAll('figure svg')) {
    const box = svg.getBoundingClientRect();
    if (!box.width) continue;
    const scale = box.width / svg.viewBox.baseVal.width;
    for (const text of svg.querySelectorAll('text')) {
      const height = parseFloat(text.getAttribute('font-size')) * scale;
      if (height < 9) bad[svg.getAttribute('aria-label')] = `letters of ${height.toFixed(1)} pixels`;
    }
    if (box.right > innerWidth + 1) bad[svg.getAttribute('aria-label')] = 'wider than the window';
  }
  return bad;
})()
"""

SORTS = """
[...document.querySelectorAll('table.sorts')].filter(table => {
  const column = table.tHead.rows[0].cells.length - 1;
  const cells = () => [...table.tBodies[0].rows].map(row => row.cells[column].textContent);
  const button = table.tHead.rows[0].cells[column].querySelector('button');
  if (!button) return true;
  const before = cells().sort().join();
  button.click();
  const up = cells();
  button.click();
  const down = cells();
  const distinct = new Set(up.map(text => parseFloat(text)).filter(x => !isNaN(x))).size;
  return up.slice().sort().join() !== before || distinct > 1 && up.join() === down.join();
}).length
"""

CONTRAST = """
(() => {
  const light = c => { const f = c.map(v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
                       return 0.2126 * f[0] + 0.7152 * f[1] + 0.0722 * f[2]; };
  const parse = s => (s.match(/[\\d.]+/g) || []).map(Number);
  const ground = e => { for (; e; e = e.parentElement) {
      if (e.tagName === 'svg') { const r = e.querySelector('rect'); return parse(getComputedStyle(r).fill); }
      const c = parse(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] === 1) return c; }
    return [255, 255, 255]; };
  const bad = {};
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const e = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || !e.checkVisibility()) continue;
    const style = getComputedStyle(e);
    const ink = light(parse(e instanceof SVGElement ? style.fill : style.color)), paper = light(ground(e));
    const ratio = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
    if (ratio < 4.5) bad[`${e.tagName}.${e.getAttribute('class')} ${ratio.toFixed(2)}`] = walker.currentNode.data.trim();
  }
  return bad;
})()
"""


class Browser:
    def __init__(self, program):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self.to = os.pipe()
        self.back, from_browser = os.pipe()

        def pipes():  # the protocol's pipes are file descriptors 3 and 4
            a, b = os.dup(to_browser), os.dup(from_browser)
            os.dup2(a, 3), os.dup2(b, 4)

        self.process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--remote-debugging-pipe", f"--user-data-dir={self.folder.name}", "about:blank"],
            preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser), os.close(from_browser)
        self.count, self.rest, self.events, self.session = 0, b"", [], None
        target = self.ask("Target.getTargets")["targetInfos"]
        target = next(t["targetId"] for t in target if t["type"] == "page")
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def receive(self):
        while b"\0" not in self.rest:
            more = os.read(self.back, 1 << 20)
            if not more:
                sys.exit("the browser went away")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def ask(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.count:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def value(self, expression):
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        if "exceptionDetails" in answer:
            sys.exit(answer["exceptionDetails"])
        return answer["result"].get("value")

    def open(self, url):
        self.ask("Page.navigate", url=url)
        while not any(e.get("method") == "Page.loadEventFired" for e in self.events):
            self.events.append(self.receive())
        self.events = [e for e in self.events if e.get("method") != "Page.loadEventFired"]

    def close(self):
        self.process.kill()
        self.process.wait()


def look(browser, url, out):
    faults = []
    os.makedirs(out, exist_ok=True)
    for domain in ["Page", "Network", "Runtime", "Log"]:
        browser.ask(f"{domain}.enable")
    # pictures are taken without scroll bars; these must not move anything
    browser.ask("Emulation.setScrollbarsHidden", hidden=True)
    for name, width, height, scale in WAYS:
        browser.ask("Emulation.setDeviceMetricsOverride", width=width, height=height,
                    deviceScaleFactor=scale, mobile=name != "desk")
        for theme in ["light", "dark"]:
            browser.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": theme}])
            browser.open(url)
            way = f"{name}-{theme}"
            wide = browser.value("document.documentElement.scrollWidth")
            print(f"{way}: window {width}, page {wide}")
            if wide > width:
                faults.append(f"{way}: the page is {wide} pixels wide in a window of {width}")
            pictures(browser, out, way, width)
            browser.value(OPEN)
            wide = browser.value("document.documentElement.scrollWidth")
            if wide > width:
                faults.append(f"{way}: the page, unfolded, is {wide} pixels wide in a window of {width}")
            for where, text in browser.value(CONTRAST).items():
                faults.append(f"{way}: contrast of {where}: {text[:60]}")
            for where, what in browser.value(SMALL_LETTERS).items():
                faults.append(f"{way}: {where}: {what}")
            if name == "desk" and browser.value(VERDICTS):
                faults.append(f"{way}: verdicts at {browser.value(VERDICTS)} in a window of {width}")
    if browser.value(SORTS):
        faults.append(f"{browser.value(SORTS)} tables are not sorted by clicks on their last heads")
    browser.ask("Emulation.clearDeviceMetricsOverride")
    printed = browser.ask("Page.printToPDF", preferCSSPageSize=True, printBackground=False)
    with open(os.path.join(out, "printed.pdf"), "wb") as file:
        file.write(base64.b64decode(printed["data"]))
    for event in browser.events:
        parameters = event.get("params", {})
        if event["method"] == "Network.requestWillBeSent":
            asked = parameters["request"]["url"]
            if not asked.startswith(("file://", "data:")):
                faults.append(f"asked the network for {asked}")
        if event["method"] in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
            faults.append(f"console: {json.dumps(parameters)[:200]}")
    return faults


def pictures(browser, out, way, width):
    parts = browser.value("[...document.querySelectorAll('header, section, details.run')].map(e => {"
                          "const r = e.getBoundingClientRect();"
                          "return [e.id || 'top', r.top + scrollY, r.height]; })")
    parts.insert(0, ["screen", 0, 900])
    for part, top, tall in parts:
        if not tall:
            continue
        clip = {"x": 0, "y": top, "width": width, "height": min(tall, TALLEST) + 1, "scale": 1}
        picture = browser.ask("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)
        with open(os.path.join(out, f"{way}-{part}.png"), "wb") as file:
            file.write(base64.b64decode(picture["data"]))


def broken_links(site):
    """Links of a site that lead nowhere."""
    faults, ids = [], {}
    pages = glob.glob(os.path.join(site, "**", "*.html"), recursive=True)
    for page in pages:
        with open(page, encoding="utf-8") as file:
            ids[os.path.realpath(page)] = file.read()
    for page in pages:
        for link in re.findall(r'href="([^"]*)"', ids[os.path.realpath(page)]):
            path, _, place = urllib.parse.unquote(link).partition("#")
            target = os.path.realpath(os.path.join(os.path.dirname(page), path) if path else page)
            if target not in ids or place and f'id="{place}"' not in ids[target]:
                faults.append(f"{page}: {link} leads nowhere")
    return faults


# what a page has in its body, and what must be said of it
PLANTED = [
    ("<p style='width: 2000px'>wide</p>", "pixels wide in a window"),
    ("<details><p style='width: 2000px'>wide</p></details>", "unfolded"),
    ("<p style='color: #999; background: #fff'>grey</p>", "contrast"),
    ("<img src='http://127.0.0.1:9/x.png'>", "asked the network"),
    ("<script>console.log('said')</script>", "console"),
    ("<div style='overflow: auto'><table><tr><th style='min-width: 1500px'>a</th><th>verdict</th></tr></table></div>",
     "verdicts at"),
    ("<figure><svg viewBox='0 0 900 90' width='900' style='max-width: 100%' aria-label='a plot'>"
     "<rect width='900' height='90' fill='#fff'/><text y='50' font-size='12'>small</text></svg></figure>",
     "letters of"),
    ("<table class='sorts'><thead><tr><th>a</th></tr></thead><tbody><tr><td>1</td></tr><tr><td>2</td></tr></tbody>"
     "</table>", "not sorted"),
]


def planted(out, program):
    """Faults that were not found."""
    missed = []
    for number, (body, said) in enumerate(PLANTED):
        folder = os.path.join(out, str(number))
        os.makedirs(folder, exist_ok=True)
        page = os.path.join(folder, "page.html")
        with open(page, "w", encoding="utf-8") as file:
            file.write(f"<!DOCTYPE html><meta name=viewport content='width=device-width'><body>{body}</body>")
        browser = Browser(program)
        try:
            faults = look(browser, "file://" + os.path.abspath(page), folder)
        finally:
            browser.close()
        if not any(said in fault for fault in faults):
            missed.append(f"planted and not found: {said} ({faults})")
    with open(os.path.join(out, "links.html"), "w", encoding="utf-8") as file:
        file.write('<a href="nowhere.html">a</a><a href="#nowhere">b</a>')
    if len(broken_links(out)) != 2:
        missed.append("planted and not found: links that lead nowhere")
    return missed


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    page, out = sys.argv[1:3]
    program = sys.argv[3] if len(sys.argv) > 3 else "chromium"
    faults, pages = [], [page]
    if page == "--planted":
        faults, pages = planted(out, program), []
    if os.path.isdir(page):
        faults = broken_links(page)
        found = glob.glob(os.path.join(page, "**", "*.html"), recursive=True)
        # the index, a scene, then pages of every depth in turn
        found.sort(key=lambda name: (name.count(os.sep), not name.endswith("index.html"), name))
        pages = found[:2] + found[2::max(1, len(found) // (PAGES - 2))]
    for number, page in enumerate(pages):
        browser = Browser(program)
        try:
            folder = out if len(pages) == 1 else os.path.join(out, str(number))
            print(page)
            faults += [f"{page}: {fault}" for fault in
                       look(browser, "file://" + os.path.abspath(page), folder)]
        finally:
            browser.close()
    for fault in faults:
        print("FAULT:", fault)
    sys.exit(1 if faults else 0)


main()

"""Opens a report of swimlab in headless Chromium, at desktop and phone width: no console errors, charts drawn, hovering
reads values, dragging zooms, pictures enlarge, nothing wider than the page. Exit code 77 without Chromium."""

import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import webdriver  # noqa: E402

CHARTS = """
return [...document.querySelectorAll('.chart')].map((box) => {
  const canvas = box.querySelector('.plot canvas'), pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let drawn = 0;
  for (let i = 3; i < pixels.length; i += 4) drawn += pixels[i] > 0;
  return {id: box.id, drawn, beyond: canvas.getBoundingClientRect().right - box.getBoundingClientRect().right, labels: box.querySelectorAll('.dygraph-axis-label').length,
          titles: box.querySelectorAll('.dygraph-label').length};
});"""

# Whatever reaches beyond the page's right edge and is not inside a box of its own that scrolls.
OVERFLOW = """
const wide = document.documentElement.clientWidth, found = [];
if (document.documentElement.scrollWidth > wide) found.push('page ' + document.documentElement.scrollWidth);
for (const e of document.querySelectorAll('main *')) {
  if (e.closest('.scroll') && !e.matches('.scroll')) continue;
  const r = e.getBoundingClientRect();
  if (r.width > 0 && (r.right > wide + 1 || r.left < -1)) found.push(e.tagName + '.' + e.className + ' ' + Math.round(r.right));
}
return found.slice(0, 8);"""


def expect(condition, message):
    if not condition:
        raise AssertionError(message)


def errors_in(page):
    """What the page complained of; the hint about reading canvases is for this test, which reads them."""
    return [entry["message"] for entry in page.console()
            if entry["level"] in ("SEVERE", "WARNING") and "willReadFrequently" not in entry["message"]]


def check_layout(page, name):
    expect(page.wait("return document.documentElement.dataset.ready === 'true'"), f"{name}: the script did not finish: {page.console()}")
    charts = page.run(CHARTS)
    expect(len(charts) >= 5, f"{name}: charts are missing: {charts}")
    for chart in charts:
        expect(chart["drawn"] > 200, f"{name}: nothing is drawn in {chart}")
        expect(chart["beyond"] <= 0, f"{name}: wider than its box: {chart}")
        expect(chart["labels"] >= 4 and chart["titles"] == 2, f"{name}: axis without labels: {chart}")
    pictures = page.run("return [...document.images].filter((i) => !(i.complete && i.naturalWidth > 0)).length")
    expect(pictures == 0, f"{name}: {pictures} pictures did not load")
    overflow = page.run(OVERFLOW)
    expect(not overflow, f"{name}: wider than the page: {overflow}")


def check_mouse(page):
    place = page.run("""const plot = document.querySelector('.chart .plot'); plot.scrollIntoView({block: 'center', behavior: 'instant'});
        const r = plot.getBoundingClientRect(); return {left: r.left, right: r.right, y: (r.top + r.bottom) / 2};""")
    legend = "return document.querySelector('.chart .legend').textContent"
    before = page.run(legend)
    width = place["right"] - place["left"]
    page.hover(place["left"] + 0.6 * width, place["y"])
    hovered = page.run(legend)
    expect(hovered != before and any(c.isdigit() for c in hovered), f"hovering does not read values: {before!r}, {hovered!r}")
    hidden = "return document.querySelector('.chart header button').hidden"
    expect(page.run(hidden), "the zoom button is there before zooming")
    page.drag(place["left"] + 0.4 * width, place["left"] + 0.7 * width, place["y"])
    expect(not page.run(hidden), "dragging does not zoom")
    page.run("document.querySelector('.chart header button').click()")
    tabs = page.run("return document.querySelectorAll('.tabs [role=tab]').length")
    expect(tabs == 2, f"two motions make two tabs, not {tabs}")
    page.run("document.querySelectorAll('.tabs [role=tab]')[1].click()")
    expect(len(page.run(CHARTS)) >= 5, "the second motion's charts are missing")
    modes = page.run("return [...document.querySelectorAll('.tabs.small button')].map((b) => b.dataset.mode)")
    expect(modes == ["close", "detail", "whole", "alone"], f"the contact sheet's modes are {modes}")
    rows = "return document.querySelectorAll('.sheet tbody tr').length"
    expect(page.run(rows) == 9, f"real, six pipelines (P6 is P5 on this display) and two wrong intervals make nine rows, not {page.run(rows)}")
    cards = page.run("return document.querySelectorAll('.cards .card').length")
    expect(cards == 6, f"six pipelines make six cards, not {cards}")
    numbers = page.run("return [...document.querySelectorAll('.sheet tbody tr:nth-child(n + 2) small')].map((e) => e.textContent)")
    expect(len(numbers) == 40 and all("px" in n for n in numbers), f"the errors under the pictures are {numbers}")
    source = "return document.querySelector('.sheet tbody tr:last-child img').src"
    detail = page.run(source)
    page.run("document.querySelector('.tabs.small [data-mode=whole]').click()")
    expect(page.run(source) != detail, "the contact sheet does not change its mode")
    expect("scale" not in page.run("return document.querySelector('.sheet .layers').style.transform"), "the whole view is magnified")
    page.run("document.querySelector('.tabs.small [data-mode=close]').click()")
    expect("scale(4)" in page.run("return document.querySelector('.sheet .layers').style.transform"), "the close-up is not magnified")
    pressed = "return document.querySelector('.chart header [aria-pressed]').getAttribute('aria-pressed')"
    expect(page.run(pressed) == "true", "curves that differ by decades are not on a logarithmic scale")
    expect(page.run(CHARTS)[0]["drawn"] > 200, "nothing is drawn on a logarithmic scale")
    page.run("document.querySelector('.chart header [aria-pressed]').click()")
    expect(page.run(pressed) == "false", "the linear scale cannot be chosen")
    expect(page.run(CHARTS)[0]["drawn"] > 200, "nothing is drawn on a linear scale")
    expect(page.run("return document.querySelector('main').textContent.includes('simulated along the motion')"), "where inertial readings come from is not told")
    series = page.run("return [...document.querySelectorAll('#chart-latency .legend span')].map((e) => e.textContent)")
    expect("P3 10 ms too far" in series and any("P3 Kalman" in s for s in series), f"the curves against latency are {series}")
    expect(page.run("return document.querySelector('#chart-budget-P3 .legend').textContent.includes('interval')"), "P3's budget lacks the interval")
    page.run("document.querySelector('.sheet .picture').click()")
    expect(page.run("return document.getElementById('lightbox').open"), "a picture does not enlarge")
    page.run("document.querySelector('#lightbox button').click()")


def main():
    if not webdriver.CHROMIUM or not webdriver.CHROMEDRIVER:
        print("skipped: chromium or chromedriver is not installed")
        return 77
    with tempfile.TemporaryDirectory(prefix="holdfast-browser-") as scratch:
        report = pathlib.Path(scratch) / "report"
        subprocess.run([sys.argv[1], "run", "--motion", "M1,M7", "--pipeline", "P0,P1,P2,P3,P4,P5,P6", "--interval-error-ms", "-10,10", "--lens", "none", "--size", "840x472", "--out", report],
                       check=True, stdout=subprocess.DEVNULL)
        url = (report / "report.html").as_uri()
        for name, width, height, phone, dark in [("desktop", 1280, 900, False, False), ("phone", 390, 844, True, False),
                                                 ("dark", 1280, 900, False, True)]:
            with webdriver.Browser(width, height, phone, dark) as page:
                page.open(url)
                check_layout(page, name)
                if name == "desktop":
                    check_mouse(page)
                errors = errors_in(page)
                expect(not errors, f"{name}: the console says {errors}")
                print(name, "ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())

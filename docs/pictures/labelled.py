#!/usr/bin/env python3
"""Lays pictures out side by side, each with its words below, and saves the page as one PNG (headless Chromium).

    docs/pictures/labelled.py OUT.png COLUMNS "words=picture.png" ...
    docs/pictures/labelled.py OUT.png sheet REPORT.html MOTION      the contact sheet of a report, as close-ups
"""

import html
import os
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/browser"))
import webdriver  # noqa: E402

STYLE = """body { margin: 0; padding: 10px; background: #fff; font: 17px/1.35 sans-serif; color: #1d2327; }
main { display: grid; gap: 10px 10px; } figure { margin: 0; } img { display: block; width: 100%; }
figcaption { padding: 5px 2px 2px; } b { font-weight: 650; }"""

SHEET = """
const tab = [...document.querySelectorAll('.tabs button')].find((b) => b.dataset.id === arguments[0]);
if (tab) tab.click();
for (const e of [...document.querySelectorAll('main > *')]) if (!e.querySelector('.sheet')) e.remove();
const sheet = document.querySelector('.sheet');
document.querySelector('main').replaceChildren(sheet);
document.querySelector('main').style.cssText = 'padding: 0; max-width: none;';
sheet.style.cssText = 'margin: 0; border: 0; box-shadow: none; border-radius: 0; overflow: visible; background: #fff;';
document.body.style.background = '#fff';
for (const th of sheet.querySelectorAll('tbody th')) th.style.cssText = 'font-size: 15px; min-width: 128px;';
for (const small of sheet.querySelectorAll('td small')) small.style.fontSize = '14px';
"""


def main():
    out, layout, *rest = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="holdfast-pictures-") as scratch:
        if layout == "sheet":
            page_file, width, script = pathlib.Path(rest[0]), 1150, (SHEET, rest[1])
        else:
            columns = int(layout)
            page_file, width, script = pathlib.Path(scratch) / "page.html", 20 + 480 * columns, None
            figures = ""
            for item in rest:
                words, picture = item.rsplit("=", 1)
                title, _, more = words.partition(". ")
                figures += (f'<figure><img src="{pathlib.Path(picture).resolve().as_uri()}"><figcaption>'
                            f"<b>{html.escape(title)}</b>{html.escape('. ' + more if more else '')}</figcaption></figure>")
            page_file.write_text(f'<meta charset="utf-8"><style>{STYLE} main {{ grid-template-columns: repeat({columns}, 1fr); }}'
                                 f"</style><main>{figures}</main>")
        # A sheet's pictures are magnified layers, which Chromium is slow to draw beyond the window: it has room for them.
        with webdriver.Browser(width, 1138 if script else 120) as page:
            page.open(page_file.resolve().as_uri())
            if script:
                page.run(*script)
            page.wait("return [...document.images].every((i) => i.complete)")
            page.screenshot(os.fspath(out), full=script is None)


if __name__ == "__main__":
    main()

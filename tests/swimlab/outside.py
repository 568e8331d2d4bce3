"""What the tests of swimlab share: the command from outside, its JSON, and a scratch folder for each test."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SWIMLAB = os.path.abspath(sys.argv[1])


def swimlab(*arguments, cwd=None):
    return subprocess.run([SWIMLAB, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=600)


def strict_json(text):
    """JSON as the standard has it: no NaN, no Infinity."""
    def refuse(name):
        raise ValueError("not finite: " + name)
    return json.loads(text, parse_constant=refuse)


def page_of(file):
    """What report.html tells: its data's page."""
    found = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', file.read_text(), re.S)
    return strict_json(found.group(1))["page"]


class Case(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="holdfast-swimlab-")
        self.dir = pathlib.Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def done(self, *arguments):
        answer = swimlab(*arguments, cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr + answer.stdout)
        return answer.stdout

    def refused(self, arguments, *words):
        """Exit code 2, a message with all the words on standard error, nothing left on disk."""
        before = sorted(self.dir.rglob("*"))
        answer = swimlab(*arguments, cwd=self.dir)
        self.assertEqual(answer.returncode, 2, answer.stderr + answer.stdout)
        for word in words:
            self.assertIn(word, answer.stderr)
        self.assertEqual(sorted(self.dir.rglob("*")), before, "something was left behind")


def main():
    unittest.main(argv=[sys.argv[0]], verbosity=2)

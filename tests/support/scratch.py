# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""What the tests in Python share: folders of their own, and programs that are run."""
import os
import subprocess
import tempfile
import unittest


def run_to_end(*command, **more):
    """A program that has ended, with its output and its errors as texts."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more}
    return subprocess.run(command, universal_newlines=True, check=False, **pipes)


def read(path):
    """A text file."""
    with open(path, encoding="utf-8") as file:
        return file.read()


class Scratch(unittest.TestCase):
    """Tests with a folder of their own each."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def text_of(self, name):
        return read(self.path(name))

    def write(self, name, text="", mode=0o644):
        """Writes a file, with its folders; returns its path."""
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path(name), mode)
        return self.path(name)

    def new_folder(self, files):
        """A new folder with {path: text}; returns its path."""
        root = tempfile.mkdtemp(dir=self.folder)
        for path, text in files.items():
            self.write(os.path.join(root, path), text)
        return root

#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The patch tool on the stand-in checkouts: apply_test.py REPOSITORY"""
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(REPOSITORY, "vins_estimator_patch"))
sys.dont_write_bytecode = True
import apply  # noqa: E402

STAND_INS = os.path.join(REPOSITORY, "tests", "vins_adapter", "stand_in")
FLAVOURS = {"vins-mono": "vins_mono", "vins-fusion": "vins_fusion"}
CPP = {"vins-mono": "vins_estimator/src/estimator.cpp",
       "vins-fusion": "vins_estimator/src/estimator/estimator.cpp"}

# What the blocks called in the first released version: (now, then).
NAMES_OF_VERSION_0_1 = [
    ("slim_init_glue.timeStock()", "slim_init_glue.beforeStock()"),
    ("slim_init_glue.recordStock(", "slim_init_glue.afterStock("),
    ("slim_init_glue.rememberHealthy(", "slim_init_glue.healthy("),
    ("slim_init_glue.serveRequest(", "slim_init_glue.requestFailed("),
    ("slim_init_glue.requestReset()", "slim_init_glue.wantReset()"),
    ("slim_init_glue.requestRecovery(", "slim_init_glue.request("),
    ("slim_init_glue.open(", "slim_init_glue.start("),
    ("slim_init_recover_callback", "slim_init_reinit_callback"),
    ("slim_init_sub_recover", "slim_init_sub_reinit"),
    ("slim_init/recover", "slim_init/reinit"),
]


def tool(*arguments):
    """Exit code, output, errors."""
    done = subprocess.run([sys.executable, apply.__file__] + list(arguments),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                          timeout=60)
    return done.returncode, done.stdout, done.stderr


class Options:
    """A command line, for run()."""

    def __init__(self, checkout, check=False, revert=False, flavour=None):
        self.checkout, self.check, self.revert, self.flavour = checkout, check, revert, flavour


def read(path):
    with open(path, "rb") as stream:
        return stream.read()


def write(path, data):
    with open(path, "wb") as stream:
        stream.write(data)


class ApplyTest(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="slim_init-apply-")
        self.addCleanup(shutil.rmtree, self.folder)

    def checkout(self, flavour):
        path = os.path.join(self.folder, flavour)
        shutil.copytree(os.path.join(STAND_INS, FLAVOURS[flavour]), path)
        return path

    def tree(self, path):
        """{file: (bytes, mode)}: also files that should not be there."""
        found = {}
        for root, _, files in os.walk(path):
            for name in files:
                file = os.path.join(root, name)
                found[os.path.relpath(file, path)] = (read(file),
                                                      stat.S_IMODE(os.stat(file).st_mode))
        return found

    def succeeds(self, *arguments):
        code, out, err = tool(*arguments)
        self.assertEqual((code, err), (0, ""))
        return out

    def refuses(self, *arguments):
        code, out, err = tool(*arguments)
        self.assertEqual((code, out), (1, ""))
        self.assertEqual(err.count("\n"), 1, err)
        return err

    def test_check_apply_again_revert(self):
        for flavour in FLAVOURS:
            with self.subTest(flavour):
                path = self.checkout(flavour)
                pristine = self.tree(path)
                files = len(apply.FLAVOURS[flavour])
                total = sum(map(len, apply.FLAVOURS[flavour].values()))

                self.assertIn("%d insertions in %d files can be made" % (total, files),
                              self.succeeds(path, "--check"))
                self.assertEqual(self.tree(path), pristine)
                self.assertIn("%s: %d insertions" % (flavour, total), self.succeeds(path))
                applied = self.tree(path)
                self.assertEqual(sum(applied[f] != pristine[f] for f in pristine), files)
                self.assertIn("already applied", self.succeeds(path))
                self.assertIn("already applied", self.succeeds(path, "--check"))
                self.assertEqual(self.tree(path), applied)
                self.assertIn("can be taken out", self.succeeds(path, "--revert", "--check"))
                self.assertEqual(self.tree(path), applied)
                self.succeeds(path, "--revert")
                self.assertEqual(self.tree(path), pristine)
                self.assertIn("nothing of slim_init", self.succeeds(path, "--revert"))
                self.assertEqual(self.tree(path), pristine)

    def test_only_whole_lines_are_added(self):
        for flavour in FLAVOURS:
            path = self.checkout(flavour)
            pristine = self.tree(path)
            self.succeeds(path)
            for file, (text, _) in self.tree(path).items():
                lines = iter(text.split(b"\n"))
                for line in pristine[file][0].split(b"\n"):
                    self.assertIn(line, lines, "%s lost a line or its place" % file)

    def test_line_ends_encoding_and_mode_stay(self):
        path = self.checkout("vins-mono")
        source = os.path.join(path, CPP["vins-mono"])
        # CRLF throughout, a byte that is no UTF-8, no end on the last line, unusual permissions.
        text = read(source).replace(b"\n", b"\r\n") + b"// caf\xe9\r // not an end"
        write(source, text)
        os.chmod(source, 0o640)
        cmake = os.path.join(path, "vins_estimator", "CMakeLists.txt")
        # The anchor is the last line and has no end.
        write(cmake, read(cmake).rstrip())
        pristine = self.tree(path)
        self.succeeds(path)
        applied = read(source)
        self.assertEqual(applied.count(b"\n"), applied.count(b"\r\n"))
        self.assertTrue(read(cmake).rstrip().endswith(b"# <<< slim_init"))
        self.assertIn("already applied", self.succeeds(path))
        self.succeeds(path, "--revert")
        self.assertEqual(self.tree(path), pristine)

    def test_other_indentation_is_the_same_anchor(self):
        path = self.checkout("vins-mono")
        source = os.path.join(path, CPP["vins-mono"])
        write(source, read(source).replace(b"    ", b"\t").replace(b"if(result)", b"if ( result )"))
        pristine = self.tree(path)
        self.succeeds(path)
        self.succeeds(path, "--revert")
        self.assertEqual(self.tree(path), pristine)

    def test_every_anchor_missing_or_twice_is_named_and_nothing_is_written(self):
        for flavour, spec in apply.FLAVOURS.items():
            path = self.checkout(flavour)
            pristine = self.tree(path)
            for file, insertions in spec.items():
                for insertion in insertions:
                    target = os.path.join(path, file)
                    lines = pristine[file][0].decode().split("\n")
                    wanted = [apply.condensed(line) for line in insertion.anchor]
                    at = next(i for i in range(len(lines))
                              if [apply.condensed(l) for l in lines[i:i + len(wanted)]] == wanted)
                    for changed, words in (
                            (lines[:at] + lines[at + 1:], "not found"),
                            (lines[:at] + lines[at:at + len(wanted)] + lines[at:], "2 times")):
                        write(target, "\n".join(changed).encode())
                        before = self.tree(path)
                        for check in (False, True):
                            # In this process: a hundred others would take a while.
                            with self.assertRaises(apply.Problem) as refusal:
                                apply.run(Options(path, flavour=flavour, check=check))
                            error = str(refusal.exception)
                            self.assertIn(file, error)
                            self.assertIn(insertion.anchor[0], error)
                            self.assertIn(words, error)
                            self.assertEqual(self.tree(path), before)
                    write(target, pristine[file][0])

    def test_half_applied_checkouts_are_completed_or_reverted(self):
        path = self.checkout("vins-mono")
        pristine = self.tree(path)
        self.succeeds(path)
        applied = self.tree(path)
        # As after a checkout of one file: some blocks are gone.
        write(os.path.join(path, CPP["vins-mono"]), pristine[CPP["vins-mono"]][0])
        self.assertIn("in place of", self.succeeds(path))
        self.assertEqual(self.tree(path), applied)
        write(os.path.join(path, CPP["vins-mono"]), pristine[CPP["vins-mono"]][0])
        self.succeeds(path, "--revert")
        self.assertEqual(self.tree(path), pristine)

    def patched_by_version_0_1(self, flavour):
        """A stand-in as the first released version left it, and its files before that."""
        path = self.checkout(flavour)
        pristine = self.tree(path)
        for file, insertions in apply.FLAVOURS[flavour].items():
            old = []
            for insertion in insertions:
                code = "\n".join(insertion.code)
                for now, then in NAMES_OF_VERSION_0_1:
                    code = code.replace(now, then)
                old.append(apply.Insertion(insertion.anchor, insertion.where, code))
            if file == CPP[flavour]:
                # A block where this version has none.
                old.append(apply.Insertion("key_poses.clear();", "after", "a_block_of_old();"))
            target = os.path.join(path, file)
            text = apply.inserted(file, pristine[file][0].decode("latin-1"), old)
            write(target, text.encode("latin-1"))
        return path, pristine

    def test_a_host_patched_by_the_previous_version_is_upgraded(self):
        for flavour in FLAVOURS:
            with self.subTest(flavour):
                path, pristine = self.patched_by_version_0_1(flavour)
                old = self.tree(path)
                text = b"".join(data for data, _ in old.values())
                for _, then in NAMES_OF_VERSION_0_1:
                    if flavour == "vins-mono" and then == "slim_init_glue.wantReset()":
                        continue  # of VINS-Fusion alone
                    self.assertIn(then.encode(), text)
                blocks = sum(map(len, apply.FLAVOURS[flavour].values()))
                self.assertIn("%d insertions" % blocks, self.succeeds(path, "--check"))
                self.assertEqual(self.tree(path), old)
                self.assertIn("in place of %d earlier ones" % (blocks + 1), self.succeeds(path))

                # The same bytes as from a checkout that was never patched.
                upgraded = self.tree(path)
                shutil.rmtree(path)
                self.succeeds(self.checkout(flavour))
                self.assertEqual(upgraded, self.tree(path))
                self.succeeds(path, "--revert")
                self.assertEqual(self.tree(path), pristine)
                shutil.rmtree(path)

                # Without the upgrade between them as well.
                self.patched_by_version_0_1(flavour)
                self.assertIn("%d insertions taken out" % (blocks + 1),
                              self.succeeds(path, "--revert"))
                self.assertEqual(self.tree(path), pristine)

    def test_broken_markers_are_named_with_their_line(self):
        path = self.checkout("vins-mono")
        self.succeeds(path)
        source = os.path.join(path, CPP["vins-mono"])
        applied = read(source)
        for broken in (applied.replace(b"// <<< slim_init\n", b"", 1),
                       applied.replace(b"// >>> slim_init\n", b"", 1),
                       applied + b"// >>> slim_init\n"):
            write(source, broken)
            before = self.tree(path)
            for mode in ([], ["--revert"]):
                error = self.refuses(path, *mode)
                self.assertRegex(error, r"estimator\.cpp:\d+: .*repair the file by hand")
                self.assertEqual(self.tree(path), before)

    @unittest.skipIf(os.name == "nt", "needs a folder that refuses files")
    def test_a_file_that_cannot_be_written_leaves_all_as_they_were(self):
        path = self.checkout("vins-mono")
        pristine = self.tree(path)
        replaced = []

        def failing(source, target):
            if len(replaced) == 3:
                raise OSError(28, "No space left on device", target)
            replaced.append(target)
            os.rename(source, target)

        original, apply.os.replace = apply.os.replace, failing
        try:
            with self.assertRaisesRegex(apply.Problem, "No space left.*nothing was changed"):
                apply.run(Options(path))
        finally:
            apply.os.replace = original
        self.assertEqual(len(replaced), 3)
        self.assertEqual(self.tree(path), pristine)

    def test_wrong_folders(self):
        self.assertIn("no such folder", self.refuses(os.path.join(self.folder, "absent")))
        self.assertIn("holds neither", self.refuses(self.folder))
        path = self.checkout("vins-mono")
        self.assertIn("cannot be read", self.refuses(path, "--flavour", "vins-fusion"))
        os.remove(os.path.join(path, "vins_estimator", "package.xml"))
        self.assertIn("package.xml: cannot be read", self.refuses(path))


if __name__ == "__main__":
    unittest.main()

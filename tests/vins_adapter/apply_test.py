#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The patch tool on the stand-in checkouts: apply_test.py REPOSITORY"""
import os
import re
import shutil
import stat
import sys
import unittest

REPOSITORY = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(REPOSITORY, "vins_estimator_patch"))
STAND_INS = os.path.join(REPOSITORY, "tests", "vins_adapter", "stand_in")
sys.path.insert(0, STAND_INS)
sys.dont_write_bytecode = True
import apply  # noqa: E402
import forks  # noqa: E402
from scratch import Scratch, run_to_end  # noqa: E402

HOSTS = apply.known_hosts()
UNREPAIRED = apply.known_hosts(repaired=False)
CPP = {name: host.code_files[1] for name, host in HOSTS.items()}


def tool(*arguments):
    """Exit code, output, errors."""
    done = run_to_end(sys.executable, apply.__file__, *arguments, timeout=60)
    return done.returncode, done.stdout, done.stderr


class Options:
    """A command line, for run()."""

    def __init__(self, checkout, check=False, revert=False, host=None):
        self.checkout, self.check, self.revert, self.host = checkout, check, revert, host
        self.without_repairs = False


def read(path):
    with open(path, "rb") as stream:
        return stream.read()


def write(path, data):
    with open(path, "wb") as stream:
        stream.write(data)


class ApplyTest(Scratch):
    def checkout(self, flavour):
        path = os.path.join(self.folder, flavour)
        forks.make(flavour.replace("-", "_"), path)
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

    def diagnosed(self, *arguments):
        """Exit code and lines."""
        code, out, err = tool(*(arguments + ("--diagnose",)))
        self.assertEqual(err, "")
        return code, out.split("\n")

    def fits(self, flavour, path):
        """It is recognised and diagnosed, and nothing is written."""
        host, before = HOSTS[flavour], self.tree(path)
        code, lines = self.diagnosed(path)
        self.assertEqual(code, 0, lines)
        self.assertTrue(any(line.startswith(flavour + ": " + host.title) for line in lines))
        self.assertIn("%d of %d anchors match; the patch can be applied"
                      % (host.total(), host.total()), lines)
        self.assertEqual(self.tree(path), before)

    def test_check_apply_again_revert(self):
        for flavour in HOSTS:
            with self.subTest(flavour):
                path = self.checkout(flavour)
                pristine = self.tree(path)
                files = len(HOSTS[flavour].files)
                total = HOSTS[flavour].total()

                self.assertIn("%d insertions in %d files can be made" % (total, files),
                              self.succeeds(path, "--check"))
                self.assertEqual(self.tree(path), pristine)
                self.fits(flavour, path)
                self.assertIn("%s: %d insertions" % (flavour, total), self.succeeds(path))
                self.fits(flavour, path)
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

    def test_repairs_of_the_host_can_be_left_out(self):
        for flavour, host in HOSTS.items():
            with self.subTest(flavour):
                path = self.checkout(flavour)
                self.succeeds(path)
                repairs, total = b"keepHeading|fillDepths", UNREPAIRED[flavour].total()
                found = [file for file, (text, _) in self.tree(path).items()
                         if re.search(repairs, text)]
                self.assertEqual(found, [] if flavour in ("gvins", "open_vins") else [CPP[flavour]])
                self.assertIn("%d insertions" % total, self.succeeds(path, "--without-repairs"))
                self.assertFalse(any(re.search(repairs, text)
                                     for text, _ in self.tree(path).values()))
                self.assertIn("%d of %d anchors match" % (total, total),
                              self.succeeds(path, "--without-repairs", "--diagnose"))

    def test_line_ends_encoding_and_mode_stay(self):
        path = self.checkout("vins-mono")
        source = os.path.join(path, CPP["vins-mono"])
        # CRLF throughout, a byte that is no UTF-8, no end on the last line, unusual permissions,
        # another indentation and other spaces.
        text = read(source).replace(b"\n", b"\r\n") + b"// caf\xe9\r // not an end"
        text = text.replace(b"    ", b"\t").replace(b"if(result)", b"if ( result )")
        write(source, text)
        os.chmod(source, 0o640)
        cmake = os.path.join(path, "vins_estimator", "CMakeLists.txt")
        # The anchor is the last line and has no end.
        write(cmake, read(cmake).rstrip())
        pristine = self.tree(path)
        self.succeeds(path)
        applied = read(source)
        self.assertEqual(applied.count(b"\n"), applied.count(b"\r\n"))
        self.assertFalse(read(cmake).endswith(b"\n"))
        self.assertIn("already applied", self.succeeds(path))
        self.succeeds(path, "--revert")
        self.assertEqual(self.tree(path), pristine)

    def test_every_anchor_missing_or_twice_is_named_and_nothing_is_written(self):
        for flavour, host in HOSTS.items():
            path = self.checkout(flavour)
            pristine = self.tree(path)
            for file, insertions in host.files.items():
                for insertion in insertions:
                    target = os.path.join(path, file)
                    lines = apply.lines_of(pristine[file][0].decode())
                    at, after = apply.anchored(file, lines, insertion)
                    for changed, words in ((lines[:at] + lines[at + 1:], "not found"),
                                           (lines[:after] + lines[at:], "2 times")):
                        write(target, "".join(changed).encode())
                        before = self.tree(path)
                        for check in (False, True):
                            # In this process: a hundred others would take a while.
                            with self.assertRaises(apply.Problem) as refusal:
                                apply.run(Options(path, host=flavour, check=check))
                            error = str(refusal.exception)
                            self.assertIn(file, error)
                            # Two insertions may share a line of their anchors.
                            self.assertTrue(any(other.anchor[0] in error for other in insertions
                                                if insertion.anchor[0] in other.anchor), error)
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

    def patched_by_an_old_version(self, flavour):
        """A stand-in with blocks of other texts, one of them elsewhere, and its files before."""
        path = self.checkout(flavour)
        pristine = self.tree(path)
        for file, insertions in HOSTS[flavour].files.items():
            old = []
            for insertion in insertions:
                code = "\n".join(insertion.code).replace("slim_init", "old_name") + "\nold_line();"
                old.append(apply.Insertion(insertion.anchor, insertion.where, code, insertion.inside))
            if file == CPP[flavour]:
                # A block where this version has none.
                old.append(apply.Insertion("last_P = Ps[WINDOW_SIZE];", "after", "a_block_of_old();"))
            target = os.path.join(path, file)
            text = apply.inserted(file, pristine[file][0].decode("latin-1"), old)
            write(target, text.encode("latin-1"))
        return path, pristine

    def test_a_host_patched_by_the_previous_version_is_upgraded(self):
        for flavour in ("vins-mono", "vins-fusion"):
            with self.subTest(flavour):
                path, pristine = self.patched_by_an_old_version(flavour)
                old = self.tree(path)
                blocks = HOSTS[flavour].total()
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
                self.patched_by_an_old_version(flavour)
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
        self.assertIn("holds none of the known hosts", self.refuses(self.folder))
        path = self.checkout("vins-mono")
        self.assertIn("cannot be read", self.refuses(path, "--flavour", "vins-fusion"))
        self.assertIn("no such host", self.refuses(path, "--host", "vins-stereo"))
        os.remove(os.path.join(path, "vins_estimator", "package.xml"))
        self.assertIn("package.xml: cannot be read", self.refuses(path))

    def test_a_diagnosis_names_what_does_not_fit(self):
        path = self.checkout("vins-mono")
        source = os.path.join(path, CPP["vins-mono"])
        header = os.path.join(path, "vins_estimator", "src", "estimator.h")
        text = read(source)
        write(source, text.replace(b"if(result)", b"if(result && ok)").replace(
            b"        if (failureDetection())", b"        if (failureDetection())\n" * 2))
        write(header, read(header).replace(b"IntegrationBase* tmp_pre_integration;", b""))
        before = self.tree(path)
        code, lines = self.diagnosed(path)
        self.assertEqual(code, 1)
        said = "\n".join(lines)
        self.assertRegex(said, r"NOT FOUND after_stock  if\(result\)\n *nearest is line \d+: "
                         r"if\(result && ok\)")
        self.assertRegex(said, r"2 TIMES   optimized    lines \d+, \d+: if \(failureDetection\(\)\)")
        self.assertRegex(said, r"NOT FOUND member  ")
        self.assertIn("11 of 14 anchors match; what to do", said)
        self.assertEqual(self.tree(path), before)

    def test_a_folder_that_is_no_host_is_diagnosed(self):
        code, lines = self.diagnosed(self.folder)
        self.assertEqual(code, 1)
        self.assertEqual(sum(", files or signs of it are missing" in line for line in lines),
                         len(HOSTS))
        self.assertIn("no such folder", tool(self.folder + "/absent", "--diagnose")[2])

    def fork(self):
        """VINS-Mono under other names, and a description of it."""
        path = self.checkout("vins-mono")
        os.rename(os.path.join(path, "vins_estimator"), os.path.join(path, "my_estimator"))
        source = os.path.join(path, "my_estimator", "src", "estimator.cpp")
        write(source, read(source).replace(b"if(result)", b"if(result == true)"))
        described = os.path.join(self.folder, "my_fork.json")
        write(described, b"""{
  "title": "My fork", "like": "vins-mono", "folder": "my_estimator",
  "insertions": {"after_stock": {"file": "source", "before": "if (result == true)"}}
}""")
        return path, described

    def test_a_fork_described_by_its_user(self):
        path, described = self.fork()
        pristine = self.tree(path)
        self.assertIn("holds none of the known hosts", self.refuses(path))
        self.assertEqual(self.diagnosed(path, "--host", described)[0], 0)
        self.assertIn("my_fork: 14 insertions in 5 files", self.succeeds(path, "--host", described))
        source = read(os.path.join(path, "my_estimator", "src", "estimator.cpp"))
        self.assertIn(b"stockTried(*this, result);\n// <<< slim_init\n            if(result == true)",
                      source)
        self.succeeds(path, "--host", described, "--revert")
        self.assertEqual(self.tree(path), pristine)

    def test_descriptions_that_are_wrong(self):
        path, described = self.fork()
        good = read(described)
        for old, new, words in (
                (b'"title"', b'"titel"', 'unknown key "titel"'),
                (b'"vins-mono"', b'"vins-solo"', "vins-solo.json: cannot be read"),
                (b'"vins-mono"', b'"my_fork"', "is like itself"),
                (b'"before"', b'"befor"', 'unknown key "befor"'),
                (b'"file": "source", ', b"", '"file" is None'),
                (b'"before"', b'"text": "no_such", "before"', "there is no text"),
                (b', "before": "if (result == true)"', b"", 'either "before" or "after"'),
                (b'"like": "vins-mono", ', b"", 'needs "files"'),
                (b'"my_estimator"', b"7", "not a description"),
                (b'"like"', b'"repairs": ["yaw"], "like"', 'repair "yaw" is no insertion'),
                (b"}\n}", b"}\n", "not JSON")):
            self.assertIn(old, good)
            write(described, good.replace(old, new))
            self.assertIn(words, self.refuses(path, "--host", described))
        os.remove(described)
        self.assertIn("cannot be read", self.refuses(path, "--host", described))

    def test_an_anchor_is_looked_for_in_its_function(self):
        text = "void a()\n{\n    x;\n}\nvoid b()\n{\n    x;\n}\n"
        ours = apply.Insertion("x;", "before", "y;", "void b() {")
        self.assertEqual(apply.inserted("f.cpp", text, [ours]),
                         text[:31] + "// >>> slim_init\ny;\n// <<< slim_init\n" + text[31:])
        # Behind a last line without an end.
        behind = apply.inserted("f.cpp", "x;", [apply.Insertion("x;", "after", "y;")])
        self.assertEqual(behind, "x;\n// >>> slim_init\ny;\n// <<< slim_init")
        self.assertEqual(apply.stripped("f.cpp", behind), ("x;", 1))
        with self.assertRaisesRegex(apply.Problem, "found 2 times"):
            apply.inserted("f.cpp", text, [apply.Insertion("x;", "before", "y;")])
        with self.assertRaisesRegex(apply.Problem, r"the anchor \"void c\(\)\" is not found"):
            apply.inserted("f.cpp", text, [apply.Insertion("x;", "before", "y;", "void c()")])

    def test_comments_and_breaks_of_lines_do_not_count(self):
        opens, call = ["if (a)", "{"], ["f(a, b);"]
        for file, text, anchor, where, found in (
                ("f.cpp", "if (a) // \"why\"\n{\n", opens, "after", [(0, 2)]),
                ("f.cpp", "\tif ( a )\r\n  {\r\n", opens, "after", [(0, 2)]),
                ("f.cpp", "if(a){\n}\n", opens, "after", [(0, 1)]),
                ("f.cpp", "if (a)\n  // why\n\n  /* and\n how */ { // on\n", opens, "after", [(0, 5)]),
                ("f.cpp", "if (a) {\n", opens[:1], "before", [(0, 1)]),
                ("f.cpp", "if (a) {\n", opens[:1], "after", []),
                ("f.cpp", "if (a) { b;\n", opens, "after", []),
                ("f.cpp", "c; if (a)\n{\n", opens, "before", []),
                ("f.cpp", "f(a,\n  b);\nc;\n", call, "after", [(0, 2)]),
                ("f.cpp", "// f(a, b);\n/*\nf(a, b);\n*/\n", call, "after", []),
                ("f.cpp", "s = \"/*\";\nf(a, b);\ns = \"*/\";\n", call, "after", [(1, 2)]),
                ("f.cpp", "f(a, b); /* c\nd */\n", call, "after", []),
                ("f.cpp", "/* c\nd */ f(a, b);\n", call, "before", []),
                ("f.cpp", "f(a,\n  b);\n", ["f(a, ..."], "after", []),
                ("f.cpp", "f(a, b);\n", ["// f"], "before", []),
                ("CMakeLists.txt", "#[[\nf(a)\n]]\nf(a)\n", ["f(a ..."], "before", [(3, 4)]),
                ("CMakeLists.txt", "f(a # b\n  c)\n# f(a)\n", ["f(a ..."], "before", [(0, 1)]),
                ("package.xml", "<!-- <a>b</a> -->\n<a>b</a> <!-- c -->\n", ["<a>b</a>"], "after",
                 [(1, 2)])):
            with self.subTest(text):
                self.assertEqual(apply.places(file, apply.lines_of(text), anchor, where), found)

    def test_every_target_finds_the_included_header(self):
        # All targets of the stand-ins have sources that include the header of the estimator.
        for flavour, host in HOSTS.items():
            for path in [path for path in host.files if path.endswith("CMakeLists.txt")]:
                with self.subTest(path):
                    checkout = self.checkout(flavour)
                    self.succeeds(checkout)
                    text = read(os.path.join(checkout, path)).decode()
                    targets = re.findall(r"^add_(?:library|executable)\((\S+)", text, re.M)
                    for target in targets:
                        self.assertRegex(
                            text, r"target_(link_libraries|include_directories)\(%s [^)]*slim_init::"
                            % re.escape(target))
                    shutil.rmtree(checkout)

    def test_what_opencv_4_has_no_longer_is_replaced(self):
        path = self.checkout("vins-mono")
        source = os.path.join(path, "vins_estimator", "src", "old.cpp")
        cmake = os.path.join(path, "vins_estimator", "CMakeLists.txt")
        write(source, b"#include <opencv/cv.h>\ncv::cvtColor(a, b, CV_GRAY2RGB);\n"
              b"f(CV_AA, cv::CV_BGR2GRAY, CV_8UC1, CV_TERMCRIT_EPS | CV_TERMCRIT_ITER);\n"
              b"cv::imread(name, CV_LOAD_IMAGE_GRAYSCALE);\n")
        write(cmake, read(cmake) + b'set(CMAKE_CXX_FLAGS "-std=c++11 -march=native")\n')
        script = os.path.join(REPOSITORY, "vins_estimator_patch", "for_opencv4.sh")

        def port(*arguments):
            done = run_to_end("bash", script, *arguments, timeout=60)
            return done.returncode, done.stdout

        self.assertEqual(port(path), (0, source + "\n1 files changed\n"))
        self.assertEqual(read(source), b"#include <opencv2/opencv.hpp>\n"
                         b"cv::cvtColor(a, b, cv::COLOR_GRAY2RGB);\n"
                         b"f(cv::LINE_AA, cv::COLOR_BGR2GRAY, CV_8UC1, "
                         b"cv::TermCriteria::EPS | cv::TermCriteria::MAX_ITER);\n"
                         b"cv::imread(name, cv::IMREAD_GRAYSCALE);\n")
        self.assertEqual(port(path, "--cxx17"), (0, cmake + "\n1 files changed\n"))
        self.assertIn(b'"-std=c++17 -march=native"', read(cmake))
        self.assertEqual(port(path, "--cxx17"), (0, "0 files changed\n"))
        self.assertEqual(port(os.path.join(path, "absent"))[0], 2)

    def test_documents_state_the_numbers_of_the_tool(self):
        readme = self.text_of(os.path.join(REPOSITORY, "vins_estimator_patch", "README.md"))
        for name, host in HOSTS.items():
            bare = UNREPAIRED[name].total()
            self.assertIn("| %s | `%s` | %s | %d | %d | %d |" % (
                host.title, name, host.checked_at, bare, host.total() - bare, len(host.files)),
                readme)
        guide = self.text_of(os.path.join(REPOSITORY, "docs", "vins_mono.md"))
        mono = HOSTS["vins-mono"]
        self.assertIn("# %d marked insertions;" % mono.total(),
                      self.text_of(os.path.join(REPOSITORY, "README.md")))
        self.assertIn("vins-mono: %d insertions in %d files can be made"
                      % (mono.total(), len(mono.files)), guide)
        self.assertIn("# %d blocks between" % mono.total(), guide)


if __name__ == "__main__":
    unittest.main()

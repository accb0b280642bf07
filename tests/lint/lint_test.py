#!/usr/bin/env python3
"""Each rule of the lint fires on a small tree that breaks it, and is silent on one that does not."""
import pathlib
import shutil
import tempfile
import unittest

import check_floors
import check_format
import check_shaders
import check_sizes
import check_words
import docker_packages

TABLE = (pathlib.Path(__file__).parent / "floors.txt").read_text()


class Tree(unittest.TestCase):
    """A folder of its own for each test."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="furnace-lint-"))
        self.addCleanup(shutil.rmtree, self.root)

    def write(self, name, text=""):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class Floors(Tree):
    def setUp(self):
        super().setUp()
        self.write("tests/lint/floors.txt", TABLE)
        for name in ("renderer/base/error.hpp", "renderer/scene/scene.hpp", "renderer/assets/asset_resolver.hpp",
                     "renderer/gl/gl.hpp", "api/problem.hpp", "renderer/frame/film.hpp", "renderer/renderer.hpp",
                     "shaders/interface/frame_block.glsl"):
            self.write(name)

    def problems(self, name, line):
        self.write(name, line + "\n")
        return check_floors.check(self.root)

    def assert_fires(self, name, line, words):
        problems = self.problems(name, line)
        self.assertEqual(len(problems), 1, problems)
        self.assertIn(f"{name}:1: ", problems[0])
        self.assertIn(words, problems[0])

    def assert_silent(self, name, line):
        self.assertEqual(self.problems(name, line), [])

    def test_own_floor_and_below(self):
        self.assert_silent("renderer/gl/x.cpp", '#include "renderer/gl/gl.hpp"')
        self.assert_silent("renderer/gl/x.cpp", '#include "renderer/base/error.hpp"')
        self.assert_silent("server/commands/x.cpp", '#include "renderer/renderer.hpp"')

    def test_upwards(self):
        self.assert_fires("renderer/base/x.cpp", '#include "renderer/scene/scene.hpp"', "may not include")

    def test_facade_is_above_its_folders(self):
        self.assert_fires("renderer/frame/x.cpp", '#include "renderer/renderer.hpp"', "may not include")

    def test_contract_and_gl_do_not_see_each_other(self):
        self.assert_fires("api/x.cpp", '#include "renderer/gl/gl.hpp"', "may not include")
        (self.root / "api/x.cpp").unlink()
        self.assert_fires("renderer/gl/x.cpp", '#include "api/problem.hpp"', "may not include")

    def test_same_number_only_where_the_table_says(self):
        self.assert_silent("renderer/assets/x.cpp", '#include "renderer/scene/scene.hpp"')
        self.assert_fires("renderer/scene/x.cpp", '#include "renderer/assets/asset_resolver.hpp"', "may not include")

    def test_product_does_not_see_tests(self):
        self.write("tests/support/y.hpp")
        self.assert_fires("server/x.cpp", '#include "tests/support/y.hpp"', "may not include")

    def test_paths_are_from_the_root(self):
        self.assert_fires("renderer/base/x.cpp", '#include "error.hpp"', "paths are from the root")

    def test_folder_on_no_floor(self):
        self.write("elsewhere/x.cpp")
        self.assertEqual(len(check_floors.check(self.root)), 1)

    def test_blocks_are_read_by_one_file(self):
        line = '#include "shaders/interface/frame_block.glsl"'
        self.assert_silent("renderer/residency/gpu_blocks.hpp", line)
        self.assert_fires("renderer/frame/x.cpp", line, "renderer/residency/gpu_blocks.hpp")

    def test_outside_headers(self):
        for name, line in (("renderer/base/x.cpp", "#include <httplib.h>"),
                           ("server/routes.cpp", "#include <httplib.h>"),
                           ("renderer/image/x.cpp", "#include <nlohmann/json.hpp>"),
                           ("renderer/gl/x.cpp", "#include <GL/glcorearb.h>"),
                           ("renderer/frame/x.cpp", "#include <EGL/egl.h>"),
                           ("renderer/scene/x.cpp", "#include <boost/optional.hpp>"),
                           ("renderer/scene/x.cpp", "#include <gtest/gtest.h>")):
            with self.subTest(name=name, line=line):
                self.assert_fires(name, line, "include")
                (self.root / name).unlink()
        self.assert_silent("server/http_server.cpp", "#include <httplib.h>")
        self.assert_silent("renderer/base/x.cpp", "#include <vector>\n#include <cstdint>\n#include <fmt/format.h>")

    def test_threads(self):
        self.assert_fires("server/x.cpp", "std::thread thread([] {});", "may only be used by")
        self.assert_fires("server/x.cpp", "auto later = std::async([] {});", "may only be used by")
        self.assert_silent("server/x.cpp", "unsigned n = std::thread::hardware_concurrency();")
        self.assert_silent("server/x.cpp", "// a std::thread would do\nconst char* s = \"std::thread\";")
        self.assert_silent("renderer/base/worker_pool.cpp", "std::thread thread([] {});")

    def test_using_namespace(self):
        self.assert_fires("server/x.cpp", "using namespace std;", "may only be used by")


class Sizes(Tree):
    def test_limit(self):
        self.write("server/x.cpp", "\n" * check_sizes.LIMIT)
        self.assertEqual(check_sizes.check(self.root, {}), [])
        self.write("server/x.cpp", "\n" * (check_sizes.LIMIT + 1))
        self.assertEqual(len(check_sizes.check(self.root, {})), 1)
        self.assertEqual(check_sizes.check(self.root, {"server/x.cpp": (500, "a table")}), [])

    def test_stale_excuse(self):
        self.write("server/x.cpp", "\n")
        self.assertEqual(len(check_sizes.check(self.root, {"server/x.cpp": (500, "a table")})), 1)
        self.assertEqual(len(check_sizes.check(self.root, {"server/gone.cpp": (500, "a table")})), 1)


class Words(Tree):
    def test_lines(self):
        bad = ("// TO" + "DO: later", "// XX" + "X", "#if" + " 0", "path = '/ho" + "me/someone/file'",
               "https:" + "//mirror.internal.net/debian")
        for line in bad:
            with self.subTest(line=line):
                self.assertEqual(len(list(check_words.problems_of_line(line))), 1)
        for line in ("#if" + " 0x10 > FLAG", "to" + "do list", "tests/home/x", "http://127.0.0.1:8080/work/", "https://github.com/x"):
            with self.subTest(line=line):
                self.assertEqual(list(check_words.problems_of_line(line)), [])

    def test_places(self):
        self.write("server/x.cpp", "int a;\n// FIX" + "ME\n")
        self.assertEqual([p.split(": ")[0] for p in check_words.check(self.root)], ["server/x.cpp:2"])


@unittest.skipIf(check_format.unsuitable(), "clang-format of another version, or none")
class Format(Tree):
    def test_style(self):
        self.write(".clang-format", "BasedOnStyle: Google\n")
        self.write("server/x.cpp", "int a = 1;\n")
        self.assertEqual(check_format.check(self.root), [])
        self.write("server/x.cpp", "int  a=1;\n")
        self.assertEqual(len(check_format.check(self.root)), 1)
        check_format.fix(self.root)
        self.assertEqual(check_format.check(self.root), [])


@unittest.skipUnless(shutil.which("glslangValidator"), "no glslangValidator")
class Shaders(Tree):
    def setUp(self):
        super().setUp()
        self.write("shaders/interface/features.glsl", "// FEATURE_RED   draws red\n// FEATURE_BLUE  draws blue\n")
        self.write("shaders/lib/one.glsl", "const float ONE = 1.0;\n")

    def problems(self, body):
        self.write("shaders/x.frag", body)
        return check_shaders.check(self.root)

    def test_expands_and_compiles(self):
        self.assertEqual(self.problems('#include "lib/one.glsl"\n#include "lib/one.glsl"\n'
                                       "layout(location = 0) out vec4 c;\nvoid main() { c = vec4(ONE); }\n"), [])

    def test_unknown_feature(self):
        self.assertIn("FEATURE_TYPO", self.problems("#if FEATURE_TYPO\n#endif\nvoid main() {}\n")[0])

    def test_error_in_one_variant_names_file_and_line(self):
        problems = self.problems("#if FEATURE_BLUE\nwrong\n#endif\nvoid main() {}\n")
        self.assertTrue(problems and all("shaders/x.frag:" in problem for problem in problems), problems)
        self.assertEqual({problem.split(" with ")[1].split(":")[0] for problem in problems},
                         {"every feature", "FEATURE_BLUE"})

    def test_cycle_and_missing_file(self):
        self.write("shaders/lib/one.glsl", '#include "lib/two.glsl"\n')
        self.write("shaders/lib/two.glsl", '#include "lib/one.glsl"\n')
        self.assertIn("cycle", self.problems('#include "lib/one.glsl"\nvoid main() {}\n')[0])
        self.assertIn("there is no shaders/lib/none.glsl", self.problems('#include "lib/none.glsl"\n')[0])


@unittest.skipUnless(docker_packages.on_image_release() and shutil.which("cmake"), "not the release of the image")
class DockerPackages(Tree):
    def test_missing_package(self):
        program = shutil.which("cmake")
        needs_uv = "FROM a AS build\nRUN install libuv1\nFROM a\nRUN install {}\n"
        self.write(docker_packages.DOCKERFILE, needs_uv.format("libarchive13"))
        problems = docker_packages.check(self.root, program)
        self.assertTrue(any("lacks libuv1 (" in problem for problem in problems), problems)
        self.assertFalse(any("lacks libarchive13 (" in problem for problem in problems), problems)


if __name__ == "__main__":
    unittest.main()

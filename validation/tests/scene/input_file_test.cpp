// Checks of a file before it is parsed: a regular file of bounded size and depth; and conversion of text for output.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"

using namespace atwood;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("atwood-input-" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
    return (path / name).string();
  }
};

std::string refusal(const std::string& path, std::size_t most = 100) {
  try {
    read_input_file(path, "a study file (TOML)", most);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::string depth_error(const std::string& text) {
  try {
    require_shallow_toml(text, "t.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "shallow";
}

std::string dotted(int levels) {
  std::string key = "a";
  for (int i = 0; i < levels; ++i) key += ".a";
  return key;
}

}  // namespace

TEST_CASE("a regular file is read whole, anything else refused by name and unread") {
  const Folder folder;
  const std::string bytes("a\0b\r\n\xff", 6);
  CHECK(read_input_file(folder.file("plain", bytes), "", 100) == bytes);
  CHECK(read_input_file(folder.file("empty", ""), "", 100).empty());
  fs::create_symlink("plain", folder.path / "link");
  CHECK(read_input_file((folder.path / "link").string(), "", 100) == bytes);
  CHECK(read_input_file(folder.file("full", std::string(100, 'x')), "", 100).size() == 100);

  const std::string pipe = (folder.path / "pipe").string();
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(refusal(pipe) == pipe + ": found a pipe; expected a study file (TOML)");
  CHECK(refusal("/dev/zero") == "/dev/zero: found a device; expected a study file (TOML)");
  CHECK_THAT(refusal(folder.path.string()), Contains("found a directory"));
  CHECK_THAT(refusal((folder.path / "none").string()), Contains("cannot be read (No such file or directory)"));
  CHECK_THAT(refusal((folder.path / "plain" / "x").string()), Contains("cannot be read (Not a directory)"));
  fs::create_symlink("itself", folder.path / "itself");
  CHECK_THAT(refusal((folder.path / "itself").string()), Contains("cannot be read"));
}

TEST_CASE("a file larger than its kind may be is refused before it is read") {
  const Folder folder;
  const std::string sparse = folder.file("sparse", "");
  fs::resize_file(sparse, std::uintmax_t{1} << 42);  // 4 TiB of nothing
  CHECK(refusal(sparse, largest::kSettings) ==
        sparse + ": found 4398046511104 bytes; expected a study file (TOML) of at most 16 MiB");
  CHECK_THAT(refusal(folder.file("over", std::string(101, 'x'))), Contains("found 101 bytes"));
}

TEST_CASE("deep nesting is found without recursion") {
  const int deep = 100'000;
  for (const std::string& text :
       {dotted(deep) + " = 1", "[" + dotted(deep) + "]", "[[" + dotted(deep) + "]]", "x = " + std::string(deep, '['),
        "x = " + std::string(deep, '{'), "x = { " + dotted(70) + " = 1 }",
        "x = { " + dotted(40) + " = { " + dotted(40) + " = 1 } }", "'a'.\"b\"." + dotted(deep) + " = 1",
        "x = \"\\\"\"\n" + dotted(deep) + " = 1", "x = 'a\\'\n" + dotted(deep) + " = 1",
        "x = \"\"\"a\"\"\"\"\"\n" + dotted(deep) + " = 1", "x = ''\n" + dotted(deep) + "= 1",
        "# \" \n" + dotted(deep) + "= 1", "x = \"a#\"\n" + dotted(deep) + " = 1"}) {
    INFO(text.substr(0, 40));
    CHECK_THAT(depth_error(text), Contains("t.toml:") && Contains("nesting deeper than 64"));
  }
  CHECK_THAT(depth_error("a = 1\nb = \"é\"\nx = " + std::string(65, '[')), Contains("t.toml:3:69: "));
  for (const std::string& text : {std::string("a.b.c = [[1.5, 2.5], [3.5]]"), "# " + dotted(deep),
                                  "x = \"" + dotted(deep) + "\"", "x = '" + std::string(deep, '[') + "'",
                                  "x = \"\"\"\n" + dotted(deep) + "\n\"\"\"", "x = '''\n" + dotted(deep) + "\n'''",
                                  "x = [" + std::string(50'000, ' ') + "1.5, 2.5]", std::string("]]]]]]\n[a]")}) {
    INFO(text.substr(0, 40));
    CHECK(depth_error(text) == "shallow");
  }
  std::string long_list = "x = [";
  for (int i = 0; i < 1000; ++i) long_list += "[0.5, 1.5],\n";
  CHECK(depth_error(long_list + "]") == "shallow");
  CHECK_THROWS_AS(require_shallow_json("{\"a'\":" + std::string(deep, '['), "x.json"), InputError);
  CHECK_NOTHROW(require_shallow_json("{\"a\":\"" + std::string(deep, '[') + "\", \"it's\": 1.5}", "x.json"));
}

TEST_CASE("more keys, values or elements than a parser takes in a second are refused unparsed") {
  const std::size_t most = 1'500'000;
  std::string list = "x = [";
  for (std::size_t i = 0; i < most; ++i) list += "1,";
  CHECK_THROWS_WITH(require_shallow_toml(list + "]", "t.toml"), Contains("t.toml:1:3000005: found more than 1500000"));
  CHECK_NOTHROW(require_shallow_toml(list.substr(0, list.size() - 2) + "]", "t.toml"));
  std::string numbers = "x = [";
  for (std::size_t i = 0; i + 1 < most; ++i) numbers += "1.5,";
  CHECK_NOTHROW(require_shallow_toml(numbers + "]", "t.toml"));  // a number's point makes no table

  const std::size_t most_keys = 300'000;
  // Texts that hold this many keys and tables.
  for (const auto& [text, keys] : {std::pair<const char*, std::size_t>{"a=1\n", 1},
                                   {"[a]\n", 1},
                                   {"[[a]]\n", 1},
                                   {"a.b.c=1\n", 3},
                                   {"[a.b]\n", 2},
                                   {"[[a.b]]\nc=[[1.5],[2.5]]\n", 3},
                                   {"x={a=1,b=1}\n", 3},
                                   {"c=[[1.5,2.5],\n[3.5]]\n", 1},
                                   {"'a=b'=\"c=d\" # e=f\n", 1},
                                   {"x=\"\"\"\na=1\n\"\"\"\n", 1}}) {
    INFO(text);
    std::string many;
    for (std::size_t i = 0; i < most_keys / keys; ++i) many += text;
    CHECK_NOTHROW(require_shallow_toml(many, "t.toml"));
    CHECK_THROWS_WITH(require_shallow_toml(many + text, "t.toml"), Contains("found more than 300000 keys and tables"));
  }

  std::string pairs = "[";
  for (std::size_t i = 0; i < 640'001; ++i) pairs += "{\"a\":1},";
  CHECK_THROWS_WITH(require_shallow_json(pairs, "t.json"), Contains("found more than 3200000 values"));
  CHECK_NOTHROW(require_shallow_json(pairs, "t.json", {.values = 3'200'006}));

  std::string object = "{";
  for (int i = 0; i < 5000; ++i) object += "\"k" + std::to_string(i) + "\":[1:2],";
  object += "\"z\":1}";
  CHECK_THROWS_WITH(require_shallow_json(object, "t.json", {.members = 5000}),
                    Contains("found more than 5000 members in one object"));
  CHECK_NOTHROW(require_shallow_json(object, "t.json", {.members = 5001}));
  CHECK_NOTHROW(require_shallow_json(object, "t.json"));
  CHECK_THROWS_WITH(scene_from_json(object), Contains("found more than 4096 members in one object"));

  std::string elements, attributes = "<a";
  for (int i = 0; i < 200'000; ++i) elements += "<a></a>\n";
  for (int i = 0; i < 1'000'000; ++i) attributes += " b=''";
  CHECK_NOTHROW(require_small_xml(elements, "t.urdf"));
  CHECK_THROWS_WITH(require_small_xml(elements + "<a/>", "t.urdf"),
                    Contains("t.urdf:200001: found more than 200000 elements"));
  CHECK_NOTHROW(require_small_xml(attributes + "/>", "t.urdf"));
  CHECK_THROWS_WITH(require_small_xml(attributes + " b=''/>", "t.urdf"),
                    Contains("found more than 1000000 attributes"));
}

TEST_CASE("files that a scene names: no pipe, no device, and nothing outside the scene's folder") {
  const Folder folder;
  const auto error = [&](const std::string& name) {
    const std::string head = "id = \"t\"\n[run]\nt_end_s = 1\nsteps = [1]\nsamples = 1\n";
    const std::string scenes[] = {
        head + "[[body]]\nmass_kg = 1\nname = \"b\"\nshape.mesh.file = \"" + name + "\"\n",
        head + "[[body]]\nmass_kg = 1\nname = \"b\"\n[truth]\nkind = \"values\"\nfile = \"" + name + "\"\n",
        head + "[domain]\ndimensions = 2\n[[fluid]]\nname = \"w\"\narrangement = \"file\"\nregion.file = \"" + name +
            "\"\nspacing_m = 0.1\nsound_speed_m_per_s = 10\ndensity_kg_per_m3 = 1000\n"};
    std::vector<std::string> errors;
    for (const std::string& scene : scenes) {
      try {
        read_scenario_text(scene, "t.toml", folder.path.string());
        errors.push_back("read");
      } catch (const InputError& refused) {
        errors.push_back(refused.what());
      }
    }
    return errors;
  };
  REQUIRE(mkfifo((folder.path / "pipe").c_str(), 0600) == 0);
  fs::create_directory(folder.path / "sub");
  fs::create_symlink("/dev/zero", folder.path / "device");
  fs::create_symlink("/etc/passwd", folder.path / "outside");
  fs::create_symlink("../..", folder.path / "sub" / "up");
  for (const auto& text : error("pipe")) CHECK_THAT(text, Contains("is a pipe; expected an ordinary file"));
  for (const auto& text : error("sub")) CHECK_THAT(text, Contains("is a folder; expected an ordinary file"));
  for (const char* name : {"device", "outside", "/etc/passwd", "../x", "sub/up/x", "sub/../../x"})
    for (const auto& text : error(name)) CHECK_THAT(text, Contains("expected a file inside the scene's folder"));
}

TEST_CASE("scenes of deep keys end in a message") {
  CHECK_THROWS_WITH(read_scenario_text(dotted(100'000) + " = 1\n", "t.toml", "."), Contains("nesting deeper than 64"));
  CHECK_THROWS_WITH(read_scenario_text("[" + dotted(100'000) + "]\n", "t.toml", "."),
                    Contains("nesting deeper than 64"));
}

TEST_CASE("text on its way to a terminal does not act") {
  CHECK(printable("plain, \xc3\xa9t\xc3\xa9") == "plain, \xc3\xa9t\xc3\xa9");
  CHECK(printable("a\x1b[31mred\x1b[0m") == "ared");
  CHECK(printable("\x1b]0;title\x07rest") == "rest");
  CHECK(printable("\x1b]8;;http://x\x1b\\link\x1b]8;;\x1b\\") == "link");
  CHECK(printable("\x1b[2J\x1b") == "");
  CHECK(printable("a\rb\bc\x7f") == "abc");
  CHECK(printable("\xc2\x9b"
                  "31mc1") == "31mc1");  // CSI in one character
  CHECK(printable("ab\xe2\x80\xae"
                  "cd") == "abcd");  // right-to-left override
  CHECK(printable("one\ntwo\n") == "one | two");
  CHECK(printable_lines("one\n\x1b[1mtwo\n") == "one\ntwo\n");
  CHECK(printable("\xff") == "\xef\xbf\xbd");
  CHECK(printable("\x1b]unclosed") == "");
}

TEST_CASE("cells that a spreadsheet would compute are marked as text, and read back") {
  for (const char* text : {"=1+1", "+1", "-1", "@x", "\tx", "\rx", "'=x", "''-"}) {
    INFO(text);
    CHECK(guarded_cell(text) == std::string("'") + text);
    CHECK(unguarded_cell(guarded_cell(text)) == text);
  }
  for (const char* text : {"", "ball", "'tis", "a=b", "1.5", "'"}) {
    INFO(text);
    CHECK(guarded_cell(text) == text);
    CHECK(unguarded_cell(text) == text);
  }
}

TEST_CASE("a scene's texts and names do not act on a terminal") {
  const auto scene = [](const std::string& title, const std::string& name) {
    return "id = \"t\"\ntitle = \"" + title +
           "\"\n[run]\nt_end_s = 1\nsteps = [1]\nsamples = 1\n[[body]]\nmass_kg = 1\nname = \"" + name + "\"\n";
  };
  CHECK_NOTHROW(read_scenario_text(scene("two\\nlines,\\ttab", "b\xc3\xa9"), "t.toml", "."));
  for (const char* acting : {"\\u001b[31m", "\\u009b31m", "\\u202e", "\\u0007", "\\r"}) {
    INFO(acting);
    CHECK_THROWS_WITH(read_scenario_text(scene(acting, "b"), "t.toml", "."),
                      Contains("t.toml:2:9: `title`") && Contains("expected a text without control characters"));
    CHECK_THROWS_WITH(read_scenario_text(scene("t", acting), "t.toml", "."), Contains("t.toml:9:8: `name`"));
  }
}

TEST_CASE("a table of values has the columns that its bodies need") {
  const Folder folder;
  const auto error = [&](const std::string& table, const std::string& shape = "") {
    folder.file("v.csv", table);
    try {
      read_scenario_text(
          "id = \"t\"\n[run]\nt_end_s = 1\nsteps = [1]\nsamples = 1\n[[body]]\nmass_kg = 1\nname = \"b\"\n" + shape +
              "[truth]\nkind = \"values\"\nfile = \"v.csv\"\n",
          "t.toml", folder.path.string());
    } catch (const InputError& refused) {
      return std::string(refused.what());
    }
    return std::string("read");
  };
  const std::string good = "t_s,body,px_m,px_m_bar,vx_m_per_s,vx_m_per_s_bar";
  CHECK(error("# source: a book\n\n" + good + "\n1,b,1,0,1,0\n") == "read");
  CHECK_THAT(error(""), Contains("v.csv:1:1: found no header"));
  CHECK_THAT(error("# nothing\n"), Contains("found no header"));
  CHECK_THAT(error("t_s,body\n1,b\n"), Contains("v.csv:1:1: found none of the columns px_m, py_m, pz_m"));
  CHECK_THAT(error("t_s,body,px,px_m_bar\n"), Contains("found none of the columns px_m"));
  CHECK_THAT(error("t_s,body,px_m,px_m_bar\n1,b,1,0\n"), Contains("found none of the columns vx_m_per_s"));
  CHECK_THAT(error("#\nt,body,px_m,px_m_bar\n"), Contains("v.csv:2:1: found no column `t_s`"));
  CHECK_THAT(error("t_s,body,px_m,vx_m_per_s,vx_m_per_s_bar\n1,b,1,1,0\n"), Contains("found no column `px_m_bar`"));
  CHECK_THAT(error(good + "\n"), Contains("found no row under the header"));
  CHECK_THAT(error(good + ",px_m\n1,b,1,0,1,0,1\n"), Contains("the column `px_m` twice"));
  CHECK_THAT(error(good + "\n1,b,1,0,1,0\n", "shape.sphere.radius_m = 1\n"),
             Contains("found no column `qw`; expected it, as a body of the scene rotates"));
}

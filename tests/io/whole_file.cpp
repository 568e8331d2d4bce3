#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <holdfast/io/whole_file.hpp>

using namespace holdfast;
namespace fs = std::filesystem;

namespace {

struct ScratchFolder {
  fs::path path = fs::temp_directory_path() / "holdfast_whole_file_test";
  ScratchFolder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~ScratchFolder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a whole file comes back byte by byte and leaves nothing beside it") {
  const ScratchFolder folder;
  const std::string bytes("one\r\ntwo\0three\xff", 15);
  io::write_whole_file(folder.path / "a", "old and longer than what follows");
  io::write_whole_file(folder.path / "a", bytes);
  CHECK(io::read_whole_file(folder.path / "a") == bytes);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 1);
}

TEST_CASE("a link is followed, not replaced") {
  const ScratchFolder folder;
  io::write_whole_file(folder.path / "real", "old");
  fs::create_symlink(folder.path / "real", folder.path / "link");
  io::write_whole_file(folder.path / "link", "new");
  CHECK(fs::is_symlink(folder.path / "link"));
  CHECK(io::read_whole_file(folder.path / "real") == "new");
}

TEST_CASE("what is no file is refused and stays what it is") {
  const ScratchFolder folder;
  CHECK_THROWS_AS(io::write_whole_file(folder.path, "x"), io::InputError);
  // A pipe of our own stands for every device: if this fails, nothing of the machine is replaced.
  const fs::path pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_AS(io::write_whole_file(pipe, "x"), io::InputError);
  CHECK(fs::is_fifo(pipe));
  CHECK_THROWS_AS(io::write_whole_file(folder.path / "absent" / "a", "x"), io::InputError);
  CHECK_THROWS_AS(static_cast<void>(io::read_whole_file(folder.path)), io::InputError);
  CHECK_THROWS_AS(static_cast<void>(io::read_whole_file(folder.path / "absent")), io::InputError);
}

TEST_CASE("a named pipe and a device are refused at once, a shell's pipe is read") {
  const ScratchFolder folder;
  const fs::path pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  alarm(30);  // a reader that waits for a writer ends the test
  CHECK_THROWS_WITH_AS(static_cast<void>(io::read_whole_file(pipe)), doctest::Contains("named pipe"), io::InputError);
  CHECK_THROWS_WITH_AS(static_cast<void>(io::read_whole_file("/dev/zero")), doctest::Contains("device"),
                       io::InputError);
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(write(ends[1], "text", 4) == 4);
  close(ends[1]);
  CHECK(io::read_whole_file("/dev/fd/" + std::to_string(ends[0])) == "text");
  close(ends[0]);
  alarm(0);
}

// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/write_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "evaluation/scratch_folder.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

TEST(WriteFile, WritesAnewAndLeavesNothingBeside) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.csv");
  EXPECT_EQ(writeFile(path, "a longer text"), "");
  EXPECT_EQ(writeFile(path, std::string("b\0c", 3)), "");
  EXPECT_EQ(readFile(path), std::string("b\0c", 3));
  EXPECT_FALSE(fs::exists(path + ".part"));
}

TEST(WriteFile, WhereItCannotTheOldFileStaysAndTheSentenceNamesIt) {
  const ScratchFolder folder;
  EXPECT_EQ(writeFile(folder.file("missing/a.csv"), "text"),
            folder.file("missing/a.csv") + " cannot be written");
  // Nothing can be written beside this one: the name is taken by a folder.
  ASSERT_EQ(writeFile(folder.file("old"), "old"), "");
  fs::create_directories(folder.file("old.part/full"));
  EXPECT_EQ(writeFile(folder.file("old"), "new"), folder.file("old") + " cannot be written");
  EXPECT_EQ(readFile(folder.file("old")), "old");
}

TEST(WriteFile, CheckWritableSaysTheSameAndChangesNothing) {
  const ScratchFolder folder;
  EXPECT_EQ(checkWritable(folder.file("missing/a.csv")),
            folder.file("missing/a.csv") + " cannot be written");
  fs::create_directories(folder.file("folder"));
  EXPECT_EQ(checkWritable(folder.file("folder")), folder.file("folder") + " cannot be written");
  EXPECT_EQ(checkWritable(folder.file("new")), "");
  EXPECT_FALSE(fs::exists(folder.file("new")) || fs::exists(folder.file("new.part")));
  ASSERT_EQ(writeFile(folder.file("old"), "old"), "");
  EXPECT_EQ(checkWritable(folder.file("old")), "");
  EXPECT_EQ(readFile(folder.file("old")), "old");
}

TEST(WriteFile, ALinkStaysOne) {
  const ScratchFolder folder;
  ASSERT_EQ(writeFile(folder.file("file"), "old"), "");
  fs::create_symlink(folder.file("file"), folder.file("link"));
  EXPECT_EQ(writeFile(folder.file("link"), "new"), "");
  EXPECT_TRUE(fs::is_symlink(folder.file("link")));
  EXPECT_EQ(readFile(folder.file("file")), "new");
}

}  // namespace
}  // namespace slim_init::evaluation

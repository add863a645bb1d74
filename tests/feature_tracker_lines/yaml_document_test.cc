// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/yaml_document.h"

#include <gtest/gtest.h>

namespace slim_init::feature_tracker_lines {
namespace {

TEST(YamlDocument, OneMapIsLeftToTheParser) {
  for (const char* text : {
           "",
           "%YAML:1.0\n",
           "%YAML:1.0\n---\nk: 1\n",
           "%YAML:1.0\r\n\r\n# words\r\n--- # words\r\nk: 1\r\nj:\r\n   i: [1,\r\n      2]\r\n",
           "%YAML:1.0\n  k: 1\n\n# further left\n  j: 2\n",
           "%YAML:1.0\nk: 1\n...\n# the end\n\n",
           "k: ...\n  - ]\n",
       }) {
    EXPECT_EQ(whyNotOneDocument(text), "") << text;
  }
}

TEST(YamlDocument, WhatTheParserMayNotReturnFrom) {
  // The parser ends the document with the line that is further left, skips three characters and
  // waits for the minus to go away.
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\n k: 1\n: 4-\n"),
            "line 3 starts further left than the first key");
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\n--- k: 1\nj: 4-\n"),
            "line 3 starts further left than the first key");
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\nk: 1\n...\n\n- 2\n"),
            "line 5 comes after the end of the document ('...')");
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\nk: 1\n... -\n"),
            "line 3 has more than the '...' that ends the document");
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\n...\n- 2\n"),
            "line 3 comes after the end of the document ('...')");
  EXPECT_EQ(whyNotOneDocument("%YAML:1.0\n---\n{k: 1}   -\n"),
            "line 3 starts with '{', must start with a key");
}

}  // namespace
}  // namespace slim_init::feature_tracker_lines

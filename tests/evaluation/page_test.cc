// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Tables and pages: one model, and what each renderer makes of it.
#include "slim_init/evaluation/page.h"

#include <gtest/gtest.h>

#include "evaluation/html_check.h"
#include "evaluation/scratch_folder.h"
#include "slim_init/evaluation/table.h"

namespace slim_init::evaluation {
namespace {

Table someTable() {
  Table table;
  table.title = "Errors";
  table.columns = {"method", "scale", "success"};
  table.rows = {{"a|b", numberCell("%.3f", 0.12345), countCell(7)},
                {"<c>", numberCell("%.3f", kNotComputed), countCell(12)}};
  return table;
}

TEST(TableCellTest, ANumberThatDoesNotExistIsADash) {
  EXPECT_EQ(numberCell("%.1f", 0.5, 100.0).text, "50.0");
  EXPECT_EQ(numberCell("%.1f", 0.5, 100.0).value, 50.0);
  EXPECT_EQ(numberCell("%.1f", kNotComputed).text, "-");
  EXPECT_EQ(countCell(-3).text, "-3");
}

TEST(MarkBest, TakesTheLowestOrHighestAndAllThatShowTheSame) {
  Table table;
  table.columns = {"method", "x"};
  for (const double value : {0.2004, 0.2001, 0.3, kNotComputed}) {
    table.rows.push_back({"m", numberCell("%.3f", value)});
  }
  Table lowest = table;
  markBest(Best::kLowest, 1, 0, 4, &lowest);
  EXPECT_TRUE(lowest.rows[0][1].best);  // 0.200 like the next one
  EXPECT_TRUE(lowest.rows[1][1].best);
  EXPECT_FALSE(lowest.rows[2][1].best);
  EXPECT_FALSE(lowest.rows[3][1].best);
  Table highest = table;
  markBest(Best::kHighest, 1, 0, 4, &highest);
  EXPECT_FALSE(highest.rows[0][1].best);
  EXPECT_TRUE(highest.rows[2][1].best);
  // Only among the rows that are named.
  Table block = table;
  markBest(Best::kLowest, 1, 2, 4, &block);
  EXPECT_FALSE(block.rows[1][1].best);
  EXPECT_TRUE(block.rows[2][1].best);
}

TEST(MarkBest, WhereAllAreLevelNoneIsBest) {
  Table table;
  table.columns = {"method", "x"};
  table.rows = {{"a", countCell(0)}, {"b", countCell(0)}};
  markBest(Best::kHighest, 1, 0, 2, &table);
  EXPECT_FALSE(table.rows[0][1].best || table.rows[1][1].best);
  table.rows.pop_back();
  markBest(Best::kHighest, 1, 0, 1, &table);
  EXPECT_FALSE(table.rows[0][1].best);
}

TEST(TableRenderers, MarkdownEscapesAndMarks) {
  Table table = someTable();
  table.rows[0][1].best = true;
  table.rows[0][1].beside = "0.2";
  EXPECT_EQ(tableMarkdown(table),
            "| method | scale | success |\n|---|---:|---:|\n"
            "| a\\|b | **0.123** (0.2) | 7 |\n| <c> | - | 12 |\n");
}

TEST(TableRenderers, TextAlignsByColumnsNotBytes) {
  Table table = someTable();
  table.rows[0][1].text += "\xE2\x80\xA0";  // a dagger: three bytes, one column
  table.rows[1][2].best = true;
  EXPECT_EQ(tableText(table),
            "Errors\n  method   scale  success\n  a|b     0.123\xE2\x80\xA0        7\n"
            "  <c>          -      12*\n");
}

TEST(TableRenderers, HtmlEscapesAndMarks) {
  Table table = someTable();
  table.rows[0][1].best = true;
  table.rows[0][1].beside = "<0.2>";
  const std::string html = tableHtml(table);
  for (const char* part :
       {"<caption>Errors</caption>", "<th class=\"name\">method</th><th>scale</th>",
        "<td><b>0.123</b> <span class=\"beside\">(&lt;0.2&gt;)</span></td>",
        "<td class=\"name\">&lt;c&gt;</td><td>-</td>"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part << "\n" << html;
  }
  EXPECT_EQ(htmlProblem(html), "");
}

TEST(HtmlText, EscapesAndReplacesWhatIsNoText) {
  EXPECT_EQ(htmlText("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(htmlText("\xC3\xA9 \xE2\x80\xA0 \xF0\x9F\x8C\x8D"),
            "\xC3\xA9 \xE2\x80\xA0 \xF0\x9F\x8C\x8D");
  const std::string replaced = "\xEF\xBF\xBD";
  EXPECT_EQ(htmlText("x\xFFy"), "x" + replaced + "y");
  EXPECT_EQ(htmlText("\xC3"), replaced);                 // cut short
  EXPECT_EQ(htmlText("\xC0\xAF"), replaced + replaced);  // "/" the long way
  EXPECT_EQ(htmlText(std::string("a\0b\x1B", 4)), "a b ");
}

TEST(PageRenderers, OneModelTwoDocuments) {
  Page page;
  page.title = "On <V1_01>";
  page.add(PageHeading{"First & last"});
  page.add(PageParagraph{"`slim` is < `drt-l`; a lone ` stays"});
  page.add(PageList{{"one", "two <b>"}});
  page.add(PageCode{"slim_init ab --x '<y>'"});
  page.add(someTable());
  page.add(PageHeading{"Second"});
  const std::string markdown = pageMarkdown(page);
  EXPECT_EQ(markdown.rfind("# On <V1_01>\n\n## First & last\n\n`slim` is", 0), 0u) << markdown;
  for (const char* part : {"\n- one\n- two <b>\n", "\n```\nslim_init ab --x '<y>'\n```\n",
                           "\n**Errors**\n\n| method |", "\n\n## Second\n"}) {
    EXPECT_NE(markdown.find(part), std::string::npos) << part << "\n" << markdown;
  }
  const std::string html = pageHtml(page, ".");
  for (const char* part :
       {"<!DOCTYPE html>", "<title>On &lt;V1_01&gt;</title>",
        "<a href=\"#part-1\">First &amp; last</a>", "<h2 id=\"part-1\">First &amp; last</h2>",
        "<code>slim</code> is &lt; <code>drt-l</code>; a lone ` stays", "<li>two &lt;b&gt;</li>",
        "<pre>slim_init ab --x '&lt;y&gt;'</pre>", "<h2 id=\"part-2\">Second</h2>"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part << "\n" << html;
  }
  EXPECT_EQ(htmlProblem(html), "");
}

TEST(PageRenderers, PicturesAreInsideThePage) {
  const ScratchFolder folder;
  Page page;
  page.title = "Pictures";
  page.add(PagePicture{"p.png", "a \"picture\""});
  page.add(PagePicture{"none.png", "another"});
  // RFC 4648, section 10.
  for (const auto& [bytes, code] : {std::pair("f", "Zg=="), std::pair("fo", "Zm8="),
                                    std::pair("foo", "Zm9v"), std::pair("foobar", "Zm9vYmFy")}) {
    folder.write("p.png", bytes);
    const std::string html = pageHtml(page, folder.path());
    EXPECT_NE(html.find(std::string("alt=\"a &quot;picture&quot;\" src=\"data:image/png;base64,") +
                        code + "\""),
              std::string::npos)
        << html;
    EXPECT_NE(html.find("another: the picture none.png cannot be read."), std::string::npos);
    EXPECT_EQ(htmlProblem(html), "");
  }
  EXPECT_NE(pageMarkdown(page).find("![a \"picture\"](p.png)"), std::string::npos);
}

TEST(HtmlCheck, FindsWhatIsWrong) {
  EXPECT_EQ(htmlProblem("<p>a<b>c</b></p>"), "");
  EXPECT_NE(htmlProblem("<p>a<b>c</p></b>"), "");
  EXPECT_NE(htmlProblem("<p>a"), "");
  EXPECT_NE(htmlProblem("<p>a < b</p>"), "");
  EXPECT_NE(htmlProblem("<img src=\"http://a/b.png\">"), "");
}

}  // namespace
}  // namespace slim_init::evaluation

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/pages.h"

/// Pages have what links and comments say that they have.
///
/// A link in a page: [text](target) or [text](target#anchor), relative to the page. A comment names
/// a page by its path from the root or from its own folder, and sections by their headings in
/// quotes: docs/laboratory.md, "What runs" and "Running it".
namespace tribus::test::references_test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = fs::path(TRIBUS_SOURCE_DIR).lexically_normal();

bool is_page(const fs::path& file) {
    return file.extension() == ".md";
}

TEST(References, WhatAPageLinksToIsThere) {
    std::size_t found = 0;
    for (const fs::path& file : project_files()) {
        if (!is_page(file)) {
            continue;
        }
        for (const std::string& target : links_in(text_of_file(kRoot / file))) {
            ++found;
            const auto dead = dead_link(kRoot, file, target);
            EXPECT_FALSE(dead) << file.string() << ": " << *dead;
        }
    }
    EXPECT_GT(found, 50U);
}

// --- Comments ------------------------------------------------------------------------------------

struct Comment {
    std::size_t line = 0;  ///< where it begins
    std::string text;      ///< its lines, one space between them
};

/// Where the comment of a line begins. A mark inside of quotes begins none.
std::size_t mark_in(std::string_view line, std::string_view mark) {
    if (line.find(mark) == std::string_view::npos) {
        return std::string_view::npos;
    }
    char quote = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (quote != 0) {
            i += line[i] == '\\' ? 1U : 0U;
            quote = i < line.size() && line[i] == quote ? '\0' : quote;
        } else if (line[i] == '"') {
            quote = line[i];
        } else if (line.substr(i).starts_with(mark) &&
                   (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) {
            return i;
        }
    }
    return std::string_view::npos;
}

std::vector<Comment> comments_in(const std::string& source, std::string_view mark) {
    std::vector<Comment> comments;
    bool goes_on = false;
    std::size_t number = 0;
    for (std::size_t begin = 0; begin < source.size();) {
        const std::size_t end = std::min(source.find('\n', begin), source.size());
        const std::string_view line = std::string_view(source).substr(begin, end - begin);
        begin = end + 1;
        ++number;
        const std::size_t at = mark_in(line, mark);
        if (at == std::string_view::npos) {
            goes_on = false;
            continue;
        }
        const std::size_t text_at = line.find_first_not_of("/#<! ", at);
        // One that follows code is a comment of its own, and may go on in the next line.
        const bool alone = line.find_first_not_of(" \t") == at;
        if (!goes_on || !alone) {
            comments.push_back({number, ""});
        }
        comments.back().text += ' ';
        comments.back().text += text_at == std::string_view::npos ? "" : line.substr(text_at);
        goes_on = true;
    }
    return comments;
}

/// What begins a comment there; nothing where no comments are known.
std::optional<std::string_view> comment_mark(const fs::path& file, const std::string& source) {
    static const std::set<std::string> with_hash{".cmake", ".dbc",    ".py",   ".rules", ".service",
                                                 ".sh",    ".toml",   ".txt",  ".conf",  ".network",
                                                 ".link",  ".netdev", ".bash", ".fish",  ".ld"};
    const std::string extension = file.extension().string();
    static const std::set<std::string> with_slashes{".h", ".cpp", ".ts", ".tsx", ".mjs"};
    if (with_slashes.contains(extension)) {
        return "//";
    }
    const bool hash = with_hash.contains(extension) || source.starts_with("#!");
    return hash ? std::optional<std::string_view>("#") : std::nullopt;
}

/// A page that a comment names, and what of it.
struct Citation {
    std::string page;
    std::vector<std::string> sections;
    bool by_number = false;
};

std::vector<Citation> citations_in(const std::string& comment) {
    static const std::regex page_form(
        R"(([A-Za-z0-9_./-]+\.md)\b((?:(?:,|,? and|,? or| to) "[^"]+")*)(,? (?:section )?[0-9])?)");
    static const std::regex section_form("\"([^\"]+)\"");
    std::vector<Citation> citations;
    if (comment.find(".md") == std::string::npos) {
        return citations;
    }
    for (std::sregex_iterator match(comment.begin(), comment.end(), page_form), none; match != none;
         ++match) {
        const std::string sections = (*match)[2];
        Citation citation{.page = (*match)[1], .sections = {}, .by_number = false};
        for (std::sregex_iterator section(sections.begin(), sections.end(), section_form);
             section != none; ++section) {
            citation.sections.push_back((*section)[1]);
        }
        citation.by_number = citation.sections.empty() && (*match)[3].matched;
        citations.push_back(std::move(citation));
    }
    return citations;
}

/// What is wrong with a citation in a comment of `file`.
std::vector<std::string> dead_parts(const fs::path& file, const Citation& citation) {
    std::vector<std::string> wrong;
    const fs::path beside = (file.parent_path() / citation.page).lexically_normal();
    const fs::path page = fs::exists(kRoot / beside) ? beside : fs::path(citation.page);
    if (page.is_absolute() || !fs::is_regular_file(kRoot / page)) {
        return {citation.page + ": there is no such page in the project"};
    }
    if (citation.by_number) {
        wrong.push_back(citation.page + ": its sections have headings, not numbers");
    }
    const auto headings = headings_in(text_of_file(kRoot / page));
    for (const std::string& section : citation.sections) {
        if (std::ranges::find(headings, section) == headings.end()) {
            wrong.push_back(citation.page + " has no section \"" + section + "\"");
        }
    }
    return wrong;
}

TEST(References, PagesAndSectionsThatCommentsNameAreThere) {
    std::size_t found = 0;
    for (const fs::path& file : project_files()) {
        // Vectors name the pages of those who published them.
        const bool foreign = file.string().starts_with("tests/vectors/");
        const std::string source = is_page(file) || foreign ? "" : text_of_file(kRoot / file);
        const auto mark = comment_mark(file, source);
        for (const Comment& comment : mark ? comments_in(source, *mark) : std::vector<Comment>{}) {
            for (const Citation& citation : citations_in(comment.text)) {
                ++found;
                for (const std::string& wrong : dead_parts(file, citation)) {
                    ADD_FAILURE() << file.string() << ":" << comment.line << ": " << wrong;
                }
            }
        }
    }
    EXPECT_GT(found, 100U);
}

// --- That all of this finds what is wrong --------------------------------------------------------

TEST(References, ADeadLinkIsFound) {
    const fs::path page = "tests/README.md";
    EXPECT_FALSE(dead_link(kRoot, page, "fuzz/README.md"));
    EXPECT_FALSE(dead_link(kRoot, page, "lab"));
    EXPECT_FALSE(dead_link(kRoot, page, "#longer"));
    EXPECT_FALSE(dead_link(kRoot, page, "https://example.org/none.md#none"));
    EXPECT_TRUE(dead_link(kRoot, page, "fuzz/README.txt"));
    EXPECT_TRUE(dead_link(kRoot, page, "#shorter"));
    EXPECT_TRUE(dead_link(kRoot, page, "fuzz/README.md#none"));
    EXPECT_TRUE(dead_link(kRoot, page, "../../outside.md"));
    EXPECT_TRUE(dead_link(kRoot, page, "/etc/passwd"));
}

TEST(References, LinksAreToldFromCode) {
    EXPECT_EQ(links_in("[a](b.md), `[c](d.md)`, [two\nlines](e.md#f)\n```\n[g](h.md)\n```\n"),
              (std::vector<std::string>{"b.md", "e.md#f"}));
}

TEST(References, AnchorsAreThoseOfGithub) {
    EXPECT_EQ(anchors_in("# A b, c: `d`\n```\n# none\n```\n## x_y – z\n## Same\n## Same\n"),
              (std::set<std::string>{"a-b-c-d", "x_y--z", "same", "same-1"}));
}

TEST(References, APageSetsAnchorsOfItsOwn) {
    EXPECT_EQ(anchors_in("| <a id=\"input-timeout\"></a>`timeout` |\n"),
              std::set<std::string>{"input-timeout"});
}

TEST(References, ACitationGoesOverLinesAndNamesSeveralSections) {
    const auto comments = comments_in(
        "int a = 1;  // see b.md\nchar c[] = \"// d.md\";\n/// (e.md, \"One\n/// two\" and\n/// "
        "\"Three\", f.md 4.2)\n",
        "//");
    ASSERT_EQ(comments.size(), 2U);
    EXPECT_EQ(citations_in(comments[0].text).at(0).page, "b.md");
    const auto citations = citations_in(comments[1].text);
    ASSERT_EQ(citations.size(), 2U);
    EXPECT_EQ(citations[0].sections, (std::vector<std::string>{"One two", "Three"}));
    EXPECT_TRUE(citations[1].by_number);
}

TEST(References, ADeadCitationIsFound) {
    const auto count = [](const std::string& page, const std::vector<std::string>& sections,
                          bool by_number = false) {
        return dead_parts("tests/tidy/references_test.cpp", {page, sections, by_number}).size();
    };
    EXPECT_EQ(count("docs/laboratory.md", {"What runs", "The guest"}), 0U);
    EXPECT_EQ(count("docs/laboratory.md", {"What runs", "What walks"}), 1U);
    EXPECT_EQ(count("docs/none.md", {}), 1U);
    EXPECT_EQ(count("docs/laboratory.md", {}, true), 1U);
}

}  // namespace
}  // namespace tribus::test::references_test

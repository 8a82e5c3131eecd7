#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/show/manual.h"
#include "tests/unit/config/show/hand_made_manual.h"

namespace tribus::test::manual_markdown_test {
namespace {

/// A line of the table of contents. Its last cell is the help of the table.
std::string content(const std::string& title, const std::string& anchor) {
    const std::string name = title.substr(1, title.find_first_of(".]") - 1);
    return "| [`" + title + "`](#" + anchor + ") | " +
           std::string(key_named(root_keys(), name).setting.help) + " |\n";
}

std::string head() {
    return "<!-- Made by tribus schema --format markdown -->\n\n"
           "# Configuration: every key\n\n"
           "The same in a terminal: `man tribus.toml`.\n"
           "\n| table | is about |\n|---|---|\n" +
           content("[runtime]", "runtime") + content("[input.NAME]", "inputname") +
           content("[output.NAME]", "outputname") + content("[pipeline.NAME]", "pipelinename") +
           content("[gpio.NAME]", "gpioname") + content("[sensor_bus.NAME]", "sensor_busname") +
           content("[sensor_type.NAME]", "sensor_typename") +
           content("[values.NAME]", "valuesname") + content("[dronecan.NAME]", "dronecanname") +
           content("[recorder]", "recorder");
}

/// The page behind its head and contents.
std::string body_of(const std::vector<ManualSection>& sections) {
    const std::string page = manual_markdown(sections);
    EXPECT_EQ(page.substr(0, head().size()), head());
    return page.substr(head().size());
}

TEST(ManualPageInMarkdown, BeginsWithItsContents) {
    EXPECT_EQ(manual_markdown({}), head());
}

TEST(ManualPageInMarkdown, IsThisForSectionsOfAllKinds) {
    EXPECT_EQ(body_of(hand_made_manual()), R"(
## The file

One `code` and [a link](a.md#b), **bold**; [x] and [y](z).

Second.

- item one goes on
- `.two`

```toml
[a-b]

c = 'x' ^ ~ \
```

.dot

## `[input.NAME]`

Text.

| key | type | range | default | meaning | example |
|---|---|---|---|---|---|
| <a id="input-timeout"></a>`timeout` | duration | `"5ms"` to `"10s"` | `"100ms"` )"
                                           R"(| Lost after this \| that. | `timeout = "260ms"` |
| <a id="input-name"></a>`name` | text |  | required | Its `name`. | `name = "a-b"` |

### `sbus`

| key | in | type | range | default | meaning | example |
|---|---|---|---|---|---|---|
| <a id="sbus-a"></a>`a` | input | text |  | none | Help. | `a = "x"` |
| <a id="sbus-b"></a>`b` | output | text |  | none | Help. | `b = "x"` |
| <a id="sbus-c"></a>`c` | both | text |  | none | Help. | `c = "x"` |
)");
}

TEST(ManualPageInMarkdown, HasLinesOf120Columns) {
    std::string text = "abcd";
    for (int i = 0; i < 23; ++i) {
        text += " abcd";
    }
    ASSERT_EQ(text.size(), 119U);
    EXPECT_EQ(body_of({{.title = "x", .text = text + "e fgh ij"}}),
              "\n## x\n\n" + text + "e\nfgh ij\n");
    EXPECT_EQ(body_of({{.title = "x", .text = "- " + text.substr(0, 114) + " efg h\n- i"}}),
              "\n## x\n\n- " + text.substr(0, 114) + " efg\n  h\n- i\n");
}

}  // namespace
}  // namespace tribus::test::manual_markdown_test

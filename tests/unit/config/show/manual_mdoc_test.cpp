#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "config/show/manual.h"
#include "tests/unit/config/show/hand_made_manual.h"

namespace tribus::test::manual_mdoc_test {
namespace {

constexpr std::string_view kHead = R"(.\" Made from the key table: tribus schema --format man
.Dt TRIBUS.TOML 5
.Os
.nh
.Sh NAME
.Nm tribus.toml
.Nd configuration of tribus
.Sh DESCRIPTION
)";
constexpr std::string_view kFoot = R"(.Sh FILES
.Bl -tag -width Ds
.It Pa /etc/tribus/NAME.toml
Configurations of the service.
.It Pa /usr/share/doc/tribus/examples
Configurations to start from.
.It Pa /usr/share/doc/tribus/docs
The pages that are named above.
.It Pa /usr/share/tribus/tribus.schema.json
The schema for editors.
.El
.Sh SEE ALSO
.Xr tribus 1
)";

/// The page without its date.
std::string page_of(const std::vector<ManualSection>& sections) {
    std::string page = manual_mdoc(sections);
    const std::size_t date = page.find(".Dd ");
    return page.erase(date, page.find('\n', date) + 1 - date);
}

/// The text between head and foot.
std::string body_of(const std::vector<ManualSection>& sections) {
    const std::string page = page_of(sections);
    EXPECT_TRUE(page.starts_with(kHead) && page.ends_with(kFoot)) << page;
    return page.substr(kHead.size(), page.size() - kHead.size() - kFoot.size());
}

TEST(ManualPageInMdoc, HasAHeadAndAFoot) {
    EXPECT_EQ(page_of({}), std::string(kHead) + std::string(kFoot));
}

TEST(ManualPageInMdoc, IsThisForSectionsOfAllKinds) {
    EXPECT_EQ(body_of(hand_made_manual()), R"(One \fBcode\fP and a link, bold; [x] and y.
.Pp
Second.
.Bl -bullet -compact
.It
item one goes on
.It
\fB.two\fP
.El
.Bd -literal -offset indent
[a\-b]

c = \(aqx\(aq \(ha \(ti \e
.Ed
.Pp
\&.dot
.Sh [input.NAME]
Text.
.Bl -tag -width Ds
.It Ic timeout
duration, \fB"5ms"\fP to \fB"10s"\fP; default: \fB"100ms"\fP.
.br
Lost after this | that.
.br
Example: \fBtimeout = "260ms"\fP
.It Ic name
text; required.
.br
Its \fBname\fP.
.br
Example: \fBname = "a\-b"\fP
.El
.Ss sbus
.Bl -tag -width Ds
.It Ic a
Inputs: text; default: none.
.br
Help.
.br
Example: \fBa = "x"\fP
.It Ic b
Outputs: text; default: none.
.br
Help.
.br
Example: \fBb = "x"\fP
.It Ic c
text; default: none.
.br
Help.
.br
Example: \fBc = "x"\fP
.El
)");
}

TEST(ManualPageInMdoc, BeginsASectionWithAListOrCodeToo) {
    EXPECT_EQ(body_of({{.title = "x", .text = "- a\n\nb"}}),
              ".Bl -bullet -compact\n.It\na\n.El\n.Pp\nb\n");
    EXPECT_EQ(body_of({{.title = "x", .text = "```\na\n```"}}),
              ".Bd -literal -offset indent\na\n.Ed\n");
}

TEST(ManualPageInMdoc, HasLinesOf80ColumnsThatBeginWithNoDot) {
    std::string text = "abcd";
    for (int i = 0; i < 15; ++i) {
        text += " abcd";
    }
    ASSERT_EQ(text.size(), 79U);
    EXPECT_EQ(body_of({{.title = "x", .text = text + "e f .x " + text + " .y"}}),
              text + "e\nf .x " + text.substr(0, 74) + "\nabcd .y\n");
    EXPECT_EQ(body_of({{.title = "x", .text = text + " .x " + text.substr(0, 74) + "e .y"}}),
              text + "\n\\&.x " + text.substr(0, 74) + "e\n\\&.y\n");
}

}  // namespace
}  // namespace tribus::test::manual_mdoc_test

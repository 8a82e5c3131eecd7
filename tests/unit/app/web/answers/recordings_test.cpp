#include "app/web/answers/recordings.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::test::recordings_test {
namespace {

using namespace web;

TEST(PlotRange, IsReadInAnyOrder) {
    const std::vector<std::string> words{"--from", "1", "--to", "20", "--width", "4000"};
    EXPECT_EQ(plot_range("from=1&to=20&width=4000"), words);
    EXPECT_EQ(plot_range("width=4000&x=&to=20&from=1"), words);
}

TEST(PlotRange, IsNoneIfAPartIsMissingOrWrong) {
    for (const std::string query :
         {"", "from=1&to=20", "from=1&to=20&width=0", "from=1&to=20&width=4001",
          "from=20&to=20&width=5", "from=-1&to=20&width=5", "from=1.5&to=20&width=5",
          "from=1&to=20&width=5 --to", "from=&to=20&width=5",
          "from=1&to=99999999999999999999&width=5"}) {
        EXPECT_FALSE(plot_range(query)) << query;
    }
}

TEST(RecordingsPlace, IsWhatTheDaemonSays) {
    EXPECT_EQ(**place_in_answer(R"({"type":"recordings","directory":"/data"})"), "/data");
    EXPECT_FALSE(*place_in_answer(R"({"type":"recordings","directory":null})"));
    EXPECT_FALSE(place_in_answer(R"({"type":"error","error":"not a request"})"));
    EXPECT_FALSE(place_in_answer(R"({"type":"status"})"));
    EXPECT_FALSE(place_in_answer("[]"));
}

constexpr const char* kInput = R"([input.a]
protocol = "ibus"
device   = "/dev/ttyAMA5"
[output.b]
protocol = "sbus"
device   = "/dev/ttyAMA3"
[pipeline.main]
from = "a"
to   = "b"
)";

TEST(RecordingsPlace, IsInTheFileOfAnAbsentDaemon) {
    const TemporaryFolder folder;
    KnownDaemon daemon{.name = "boat", .tells = {}, .control = {}, .file = folder / "boat.toml"};
    EXPECT_FALSE(place_in_file(daemon)) << "there is none";
    folder.write("boat.toml", kInput);
    ASSERT_TRUE(place_in_file(daemon)) << place_in_file(daemon).error();
    EXPECT_FALSE(*place_in_file(daemon));
    folder.write("boat.toml", std::string(kInput) + "[recorder]\ndirectory = \"/data\"\n");
    EXPECT_EQ(**place_in_file(daemon), "/data");
    folder.write("boat.toml", std::string(kInput) + "[recorder]\n");
    ASSERT_FALSE(place_in_file(daemon)) << "/var/lib/tribus/boat is not there";
    EXPECT_NE(place_in_file(daemon).error().find("/var/lib/tribus/boat"), std::string::npos);
    folder.write("boat.toml", "[recorder]\ndirectory = 1\n");
    EXPECT_FALSE(place_in_file(daemon));
}

}  // namespace
}  // namespace tribus::test::recordings_test

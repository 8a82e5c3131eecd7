#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "config/schema/schema.h"
#include "tests/reference/plain_link.h"
#include "tests/support/pages.h"
#include "tests/support/stored_numbers.h"
#include "tests/support/streams.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"
#include "transports/codecs/authenticated/broadcast.h"

/// The example of docs/protocols/authenticated.md: the program, and an implementation that was
/// written from the page alone, make its bytes.
namespace tribus::test::page_bytes_test {
namespace {

using namespace authenticated_link;
using reference::LinkBytes;
using reference::PlainLink;

constexpr std::uint64_t kNumber = 0x0102030405060708;

/// The lines of the example, by their first words.
std::map<std::string, std::string> example() {
    std::map<std::string, std::string> lines;
    for (const Fence& fence :
         fences_of(std::filesystem::path(TRIBUS_SOURCE_DIR) / "docs/protocols/authenticated.md")) {
        std::istringstream text(fence.text);
        for (std::string line; std::getline(text, line);) {
            const std::size_t end = line.find("  ");
            const std::size_t begin = line.find_first_not_of(' ', end);
            lines[line.substr(0, end)] = begin == std::string::npos ? "" : line.substr(begin);
        }
    }
    return lines;
}

class PageBytes : public ::testing::Test {
  protected:
    LinkBytes bytes(const std::string& line) const {
        const auto found = example_.find(line);
        EXPECT_NE(found, example_.end()) << line;
        return found == example_.end() ? LinkBytes{} : from_hex(found->second);
    }
    static LinkBytes part(const LinkBytes& message, std::size_t begin, std::size_t end) {
        return {message.begin() + static_cast<std::ptrdiff_t>(begin),
                message.begin() + static_cast<std::ptrdiff_t>(end)};
    }
    /// Body and MAC.
    static LinkBytes with(LinkBytes body, const LinkBytes& mac) {
        body.insert(body.end(), mac.begin(), mac.end());
        return body;
    }
    LinkMacs macs() const { return {counted_secret(), example_.at("name of the link")}; }
    PlainLink plain() const { return {bytes("key file"), example_.at("name of the link")}; }

    std::map<std::string, std::string> example_ = example();
    LinkBytes session_ = part(bytes("hello"), 0, 3);
    LinkBytes nonce_ = part(bytes("challenge"), 8, 16);
};

TEST_F(PageBytes, AreThoseOfItsText) {
    const LinkBytes hello = part(bytes("hello"), 0, 8);
    const LinkBytes challenge = part(bytes("challenge"), 0, 16);
    const LinkBytes snapshot = part(bytes("snapshot"), 0, 48);
    const LinkBytes unanswered = part(bytes("snapshot, epoch"), 0, 48);
    EXPECT_EQ(bytes("hello"), with(hello, plain().hello_mac(hello)));
    EXPECT_EQ(bytes("challenge"), with(challenge, plain().challenge_mac(session_, challenge)));
    EXPECT_EQ(bytes("snapshot"), with(snapshot, plain().snapshot_mac(nonce_, session_, snapshot)));
    EXPECT_EQ(bytes("snapshot, epoch"), with(unanswered, plain().broadcast_mac(unanswered)));
}

TEST_F(PageBytes, AreThoseOfTheProgram) {
    Sender sender(macs(), seed_of(kSession));
    HelloMessage hello{};
    ASSERT_TRUE(sender.write_hello(hello, at(0ms)));
    EXPECT_EQ(copy_of(hello), bytes("hello"));
    ASSERT_TRUE(sender.hear(bytes("challenge"), at(0ms)));
    SnapshotMessage snapshot{};
    ASSERT_TRUE(sender.write(sticks(at(2ms) - 1500us), snapshot, at(2ms)));
    EXPECT_EQ(copy_of(snapshot), bytes("snapshot"));

    StoredNumbers numbers(kNumber);
    BroadcastSender broadcast(
        Mac(link_key(counted_secret(), Purpose::broadcast, example_.at("name of the link"))));
    broadcast.use_numbers(numbers);
    EXPECT_FALSE(broadcast.write(sticks(at(2ms)), snapshot, at(2ms))) << "no number is stored";
    numbers.store();
    ASSERT_TRUE(broadcast.write(sticks(at(2ms) - 1500us), snapshot, at(2ms)));
    EXPECT_EQ(copy_of(snapshot), bytes("snapshot, epoch"));
}

/// The names of links, as the page's table has them.
TEST_F(PageBytes, AreOfTheNameThatAConfigurationGivesTheLink) {
    const TemporaryFolder folder;
    std::filesystem::permissions(folder.write("a.key", std::string(64, '7')),
                                 std::filesystem::perms::owner_read);
    const auto name_with = [&](const std::string& lines) {
        const auto configuration = load_configuration(
            "[input.in]\n" + lines + "key = \"" + folder / "a.key" +
                "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                "[pipeline.main]\nfrom = \"in\"\nto = \"servos\"\n",
            "names.toml");
        EXPECT_TRUE(configuration) << lines;
        return configuration ? link_with_key(configuration->inputs.front())->name : "";
    };
    const std::string can = "protocol = \"can\"\ninterface = \"can0\"\n";
    const std::string network = "protocol = \"network\"\naddress = \"127.0.0.1:5700\"\n";
    EXPECT_EQ(name_with(can + "fd = true\n"), example_.at("name of the link"));
    EXPECT_EQ(name_with(can + "fd = true\nlink = \"boat\"\n"), "can fd 768 boat");
    EXPECT_EQ(name_with(can), "can 768");
    EXPECT_EQ(name_with(can + "id = 0x1234500\nextended = true\n"), "can 19088640x");
    EXPECT_EQ(name_with(can + "id = 0x1234500\nextended = true\nlink = \"boat\"\n"),
              "can 19088640x boat");
    EXPECT_EQ(name_with(network), "network");
    EXPECT_EQ(name_with(network + "link = \"boat to shore\"\n"), "network boat to shore");
}

}  // namespace
}  // namespace tribus::test::page_bytes_test

#include "tests/lab/bus_speaker.h"

#include <cstddef>
#include <fstream>

#include <fmt/format.h>

#include "tests/lab/raw_can.h"
#include "tests/support/can_snapshots.h"
#include "tests/support/dronecan_frames.h"
#include "transports/codecs/dronecan/types.h"

namespace tribus::test {
namespace {

class NativeSpeaker final : public BusSpeaker {
  public:
    std::vector<CanFrame> frames(const Sticks& sticks) override {
        ChannelFrame snapshot;
        for (std::size_t channel = 0; channel < sticks.size(); ++channel) {
            snapshot.set(channel, Pulse::from_microseconds(sticks[channel]));
        }
        snapshot.frame_lost = snapshot.failsafe = false;
        snapshot.received = can_time({});
        return can_frames(encoder_, snapshot);
    }

  private:
    CanChannelsEncoder encoder_;
};

class RcInputSpeaker final : public BusSpeaker {
  public:
    std::vector<CanFrame> frames(const Sticks& sticks) override {
        dronecan::RcInput message;
        message.status = dronecan::RcInput::kQualityValid;
        message.quality = 255;
        for (const int stick : sticks) {
            message.rcin.push_back(static_cast<std::uint16_t>(stick));
        }
        constexpr std::uint8_t kTransferIds = 32;
        transfer_id_ = static_cast<std::uint8_t>((transfer_id_ + 1) % kTransferIds);
        return frames_of_message(message, 42, transfer_id_);
    }

  private:
    std::uint8_t transfer_id_ = 0;
};

constexpr std::uint32_t kFirstDbcId = 0x100;
constexpr std::size_t kDbcMessages = 4;
constexpr std::size_t kChannelsEach = 4;
constexpr unsigned kChannelBits = 12;

/// Four channels of 12 bits and a counter of 4 bits in Intel order: the first is in the lowest
/// bits.
class DbcSpeaker final : public BusSpeaker {
  public:
    std::vector<CanFrame> frames(const Sticks& sticks) override {
        counter_ = (counter_ + 1) % 16;
        std::vector<CanFrame> frames;
        for (std::size_t message = 0; message < kDbcMessages; ++message) {
            std::uint64_t bits = counter_ << (kChannelBits * kChannelsEach);
            for (std::size_t i = 0; i < kChannelsEach; ++i) {
                const auto stick = static_cast<std::uint64_t>(sticks[message * kChannelsEach + i]);
                bits |= stick << (kChannelBits * i);
            }
            std::vector<std::uint8_t> data;
            for (unsigned byte = 0; byte < 8; ++byte) {
                data.push_back(static_cast<std::uint8_t>(bits >> (8 * byte)));
            }
            frames.push_back(make_frame(kFirstDbcId + static_cast<std::uint32_t>(message), data));
        }
        return frames;
    }

  private:
    std::uint64_t counter_ = 0;
};

template <class Speaker>
std::unique_ptr<BusSpeaker> speaker_of() {
    return std::make_unique<Speaker>();
}

std::string dbc_signals() {
    std::string text;
    for (std::size_t message = 0; message < kDbcMessages; ++message) {
        text +=
            fmt::format("[input.bus.signals.Sticks{}]\nCount = {{ counter = true }}\n", message);
        for (std::size_t i = 0; i < kChannelsEach; ++i) {
            text += fmt::format("Channel{} = {}\n", i, message * kChannelsEach + i + 1);
        }
    }
    return text;
}

}  // namespace

const std::vector<BusLanguage>& bus_languages() {
    static const std::vector<BusLanguage> all{
        {"Native", "protocol = \"can\"", "", speaker_of<NativeSpeaker>},
        {"DroneCan", "protocol = \"dronecan\"", "", speaker_of<RcInputSpeaker>},
        {"Dbc", "protocol = \"dbc\"\ndbc = \"rc.dbc\"", dbc_signals(), speaker_of<DbcSpeaker>},
    };
    return all;
}

void write_counted_dbc(const std::filesystem::path& folder) {
    std::ofstream file(folder / "rc.dbc");
    for (std::size_t message = 0; message < kDbcMessages; ++message) {
        file << fmt::format("BO_ {} Sticks{}: 8 Sender\n", kFirstDbcId + message, message);
        for (std::size_t i = 0; i < kChannelsEach; ++i) {
            file << fmt::format(" SG_ Channel{} : {}|{}@1+ (1,0) [0|4095] \"us\" Receiver\n", i,
                                kChannelBits * i, kChannelBits);
        }
        file << " SG_ Count : 48|4@1+ (1,0) [0|15] \"\" Receiver\n\n";
    }
}

}  // namespace tribus::test

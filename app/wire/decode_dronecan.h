#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/decoding.h"
#include "app/wire/dronecan/dronecan_explainer.h"
#include "transports/recordings/recording_source.h"

namespace tribus {

inline constexpr const char* kDroneCanName = "dronecan";

/// True if most transfers of the log are complete and of known types.
bool is_dronecan(RecordingSource& recording);

/// All transfers of a DroneCAN bus, not only those with channels, one a line, then a summary.
class TransferDecoding final : public Decoding {
  public:
    /// `columns`: width of the terminal, if text goes to one.
    TransferDecoding(std::optional<std::size_t> columns, const DecodeOutput& output);

    void heading() override;
    void feed_frame(const RecordedCanFrame& frame) override { explainer_.feed(frame); }
    void finish(const LogFacts& log) override;
    /// Nothing: its summary already explains every frame, so no other protocol is suggested.
    DecodedAmount amount() const override { return {}; }
    std::string_view protocol() const override { return kDroneCanName; }

  private:
    std::optional<std::size_t> columns_;
    DecodeOutput output_;
    DroneCanExplainer explainer_;
};

/// All protocols except DroneCAN, which cannot be told from others before the whole log is there.
std::vector<ProtocolUse> without_dronecan(std::span<const ProtocolUse> uses);

/// True if the log is DroneCAN and none of `uses` finds anything else in it.
bool only_dronecan(RecordingSource& recording, std::span<const ProtocolUse> uses);

}  // namespace tribus

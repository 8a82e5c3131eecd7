#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "app/wire/dronecan/dronecan_explainer.h"

/// Transfers of a DroneCAN bus as lines of text, CSV or JSON.
namespace tribus {

/// `uavcan.protocol.GetNodeInfo`; for unknown types `message type 1234` or `service 200`.
std::string type_text(dronecan::TransferKind kind, std::uint16_t data_type_id);
/// "message", "request", "response".
std::string_view kind_name(dronecan::TransferKind kind);

/// `columns`: width of the terminal; longer lines are broken between words.
void append_transfer_text_heading(std::string& text);
void append_transfer_text(std::string& text, const ExplainedTransfer& transfer,
                          std::optional<std::size_t> columns);
void append_transfer_summary_text(std::string& text, const TransferTally& tally);

void append_transfer_csv_heading(std::string& text);
void append_transfer_csv(std::string& text, const ExplainedTransfer& transfer);

/// A complete RCInput transfer also has the keys of a decoded frame.
void append_transfer_json(std::string& text, const ExplainedTransfer& transfer);
void append_transfer_summary_json(std::string& text, const TransferTally& tally,
                                  std::string_view input);

}  // namespace tribus

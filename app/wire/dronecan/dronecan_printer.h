#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>

#include "app/wire/dronecan/dronecan_explainer.h"
#include "app/wire/frames/frame_printer.h"

namespace tribus {

/// Prints the transfers of a DroneCAN bus, one a line, then a summary.
class TransferPrinter {
  public:
    /// The summary of a CSV goes to `messages`, all other output to `results`; both must outlive
    /// the printer. `columns`: width of the terminal, if text goes to one.
    TransferPrinter(DecodeFormat format, std::optional<std::size_t> columns, std::ostream& results,
                    std::ostream& messages);

    void heading();
    void transfer(const ExplainedTransfer& transfer);
    void summary(const TransferTally& tally);

  private:
    DecodeFormat format_;
    std::optional<std::size_t> columns_;
    std::ostream& results_;
    std::ostream& messages_;
};

}  // namespace tribus

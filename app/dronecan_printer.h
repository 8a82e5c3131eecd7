#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>

#include "app/dronecan_explainer.h"
#include "app/frame_printer.h"

namespace tribus {

/// Writes what was said on a DroneCAN bus: a line for each transfer, then a summary.
class TransferPrinter {
  public:
    /// The summary of a CSV goes to `talk`, every other output to `results`. `columns`: of the
    /// terminal that text is for, if it is for one. `results` and `talk` must outlive it.
    TransferPrinter(DecodeFormat format, std::optional<std::size_t> columns, std::ostream& results,
                    std::ostream& talk);

    void heading();
    void transfer(const ExplainedTransfer& transfer);
    void summary(const TransferTally& tally);

  private:
    DecodeFormat format_;
    std::optional<std::size_t> columns_;
    std::ostream& results_;
    std::ostream& talk_;
};

}  // namespace tribus

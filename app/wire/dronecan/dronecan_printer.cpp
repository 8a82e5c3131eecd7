#include "app/wire/dronecan/dronecan_printer.h"

#include <ostream>
#include <string>

#include "app/wire/dronecan/dronecan_text.h"

namespace tribus {

TransferPrinter::TransferPrinter(DecodeFormat format, std::optional<std::size_t> columns,
                                 std::ostream& results, std::ostream& messages)
    : format_(format), columns_(columns), results_(results), messages_(messages) {}

void TransferPrinter::heading() {
    std::string text;
    if (format_ == DecodeFormat::text) {
        append_transfer_text_heading(text);
    } else if (format_ == DecodeFormat::csv) {
        append_transfer_csv_heading(text);
    }
    results_ << text;
}

void TransferPrinter::transfer(const ExplainedTransfer& transfer) {
    std::string text;
    switch (format_) {
        case DecodeFormat::text:
            append_transfer_text(text, transfer, columns_);
            break;
        case DecodeFormat::json:
            append_transfer_json(text, transfer);
            break;
        case DecodeFormat::csv:
            append_transfer_csv(text, transfer);
            break;
    }
    results_ << text;
}

void TransferPrinter::summary(const TransferTally& tally) {
    std::string text;
    if (format_ == DecodeFormat::json) {
        append_transfer_summary_json(text, tally, recording_kind_name(RecordingKind::candump));
    } else {
        append_transfer_summary_text(text, tally);
    }
    (format_ == DecodeFormat::csv ? messages_ : results_) << text;
}

}  // namespace tribus

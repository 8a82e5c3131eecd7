#include "app/init/messages.h"

#include <algorithm>
#include <ostream>
#include <string>

#include "app/doctor/report.h"
#include "app/journal/journal.h"
#include "config/show/paragraph.h"

namespace tribus::init {

void Messages::say(std::string_view text, std::string_view first) {
    const std::string rest(first.size(), ' ');
    out_ << paragraph(first, rest, without_control_characters(text), columns_);
}

void Messages::line(std::string_view text) {
    out_ << text << '\n';
}

void Messages::side_by_side(const std::vector<std::string>& texts) {
    constexpr std::size_t kGap = 2;
    std::size_t width = 0;
    for (const std::string& text : texts) {
        width = std::max(width, text.size() + kGap);
    }
    const std::size_t a_line =
        std::max<std::size_t>((columns_ + kGap) / std::max<std::size_t>(width, 1), 1);
    for (std::size_t i = 0; i < texts.size(); ++i) {
        const bool ends_line = (i + 1) % a_line == 0 || i + 1 == texts.size();
        out_ << texts[i] << (ends_line ? "\n" : std::string(width - texts[i].size(), ' '));
    }
}

void Messages::findings(const std::vector<doctor::Finding>& findings) {
    doctor::Report report;
    report.findings = findings;
    std::ranges::stable_sort(report.findings, {}, &doctor::Finding::severity);
    out_ << doctor::report_text(report, columns_, colour_);
}

void Messages::prompt() {
    out_ << "> " << std::flush;
}

}  // namespace tribus::init

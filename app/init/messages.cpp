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

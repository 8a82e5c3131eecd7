#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/screen_parts.h"
#include "app/doctor/line_advice.h"
#include "app/doctor/report.h"
#include "app/pwm/pwm_text.h"
#include "config/show/paragraph.h"

namespace tribus::doctor {
namespace {

constexpr std::size_t kFewestColumns = 40;

/// Breaks text into lines; a word longer than a line stays whole.
class Page {
  public:
    Page(std::size_t columns, bool colour)
        : columns_(std::max(columns, kFewestColumns)), colour_(colour) {}

    /// `first` begins the first line; the others are indented by its length.
    void paragraph(std::string_view first, std::string_view text, std::string_view tint = {}) {
        const std::string indent(first.size(), ' ');
        add(first, tint);
        text_ += tribus::paragraph(first, indent, text, columns_).substr(first.size());
    }
    void line(std::string_view text, std::string_view tint = {}) {
        add(text, tint);
        text_ += '\n';
    }
    std::string take() { return std::exchange(text_, {}); }

  private:
    void add(std::string_view text, std::string_view tint) {
        const bool tinted = colour_ && !tint.empty();
        text_ += tinted ? tint : std::string_view();
        text_ += text;
        text_ += tinted ? screen::kReset : std::string_view();
    }

    std::size_t columns_;
    bool colour_;
    std::string text_;
};

std::string abilities(const PortOpinion& opinion, Ability wanted) {
    std::string text;
    for (const PortAbility& one : opinion.abilities) {
        if (one.ability == wanted) {
            text += text.empty() ? "" : ", ";
            text += one.protocol;
            text += one.because.empty() ? "" : fmt::format(" ({})", one.because);
        }
    }
    return text;
}

void print_port(const ExaminedPort& port, Page& page) {
    if (port.opinion.kind.empty()) {
        return;
    }
    page.paragraph("", fmt::format("{}: {}", port.facts.node, port.opinion.kind));
    if (port.facts.device != port.facts.node) {
        page.paragraph("  name     ", port.facts.device);
    }
    const auto list = [&](std::string_view head, Ability ability) {
        const std::string text = abilities(port.opinion, ability);
        if (!text.empty()) {
            page.paragraph(head, text);
        }
    };
    list(port.tried ? "  takes    " : "  can      ", Ability::yes);
    list("  perhaps  ", Ability::unknown);
    list("  cannot   ", Ability::no);
    if (port.story) {
        page.paragraph("  hears    ", describe(*port.story));
    }
    if (!port.lines.empty()) {
        const bool later = port.story && port.story->sound != LineSound::frames;
        page.paragraph(
            "  ", later ? "For the configuration, when that is fixed:" : "For the configuration:");
        for (const std::string& line : port.lines) {
            page.line(line.empty() ? line : "    " + line);
        }
        if (port.story && !port.story->scale.name.empty()) {
            page.paragraph("  ", "scale: " + port.story->scale.reason);
        }
    }
}

void print_input(const InputFacts& facts, Page& page) {
    const std::string text = describe(facts);
    if (text.empty()) {
        return;
    }
    page.paragraph("", fmt::format("{}: {}", facts.device.node, text));
    if (facts.device.has_stable_name()) {
        page.paragraph("  name     ", facts.device.device);
    }
    const std::vector<std::string> lines = configuration_lines(facts);
    if (facts.refusal && !lines.empty()) {
        page.paragraph("  ", fmt::format("For the configuration; `tribus learn {}` finds which "
                                         "stick and button is which channel:",
                                         facts.device.device));
        for (const std::string& line : lines) {
            page.line("    " + line);
        }
    }
}

void print_pwm(const PwmFacts& facts, Page& page) {
    page.paragraph("", "PWM chip " + pwm_chip_text(facts.chip));
    for (const auto& [output, state] : facts.taken) {
        page.line(fmt::format("  output {:2}  {}", output, pwm_output_text(state)));
    }
}

void print_lines(const std::vector<std::string>& lines, Page& page) {
    if (!lines.empty()) {
        page.paragraph("  ", "For the configuration:");
    }
    for (const std::string& line : lines) {
        page.line("    " + line);
    }
}

void print_gpio(const GpioFacts& facts, Page& page) {
    page.paragraph("", fmt::format("{}: {}", facts.chip.path, describe(facts)));
    for (const unsigned offset : facts.asked) {
        const GpioLineFacts& line = facts.chip.lines[offset];
        const std::string use = !line.used              ? "free"
                                : line.consumer.empty() ? "in use"
                                                        : "in use by " + line.consumer;
        page.line(fmt::format("  line {:3}  {:<20} {}", offset,
                              line.name.empty() ? "without a name" : line.name, use));
    }
    print_lines(configuration_lines(facts), page);
}

void print_spi_port(const SpiFacts& facts, Page& page) {
    if (facts.access.exists) {
        page.paragraph("", facts.device +
                               ": SPI port; its data lines can be those of SBUS without an "
                               "inverter (out by MOSI, or in by MISO), and MOSI can make PPM");
    }
    if (facts.loopback) {
        page.paragraph("  ", describe(*facts.loopback));
    }
    if (facts.refusal) {
        print_lines(configuration_lines(facts), page);
    }
}

std::string_view colour_of(Severity severity) {
    return severity == Severity::problem  ? screen::kRed
           : severity == Severity::advice ? screen::kYellow
                                          : screen::kDim;
}

void print_finding(const Finding& finding, Page& page) {
    const std::string head = fmt::format("{:<9}", severity_name(finding.severity));
    page.paragraph(head,
                   fmt::format("{}{}{} [{}]", finding.where, finding.where.empty() ? "" : ": ",
                               finding.what, finding.id),
                   colour_of(finding.severity));
    constexpr std::string_view kIndent = "         ";
    for (const std::string& text : {finding.why, finding.fix}) {
        if (!text.empty()) {
            page.paragraph(kIndent, text);
        }
    }
    for (const std::string& command : finding.commands) {
        page.line(std::string(kIndent) + "  " + command);
    }
}

std::string machine_line(const MachineFacts& machine) {
    return fmt::format("{}{}Linux {}{}", machine.model, machine.model.empty() ? "" : ", ",
                       machine.kernel, machine.realtime_kernel ? ", PREEMPT_RT" : "");
}

}  // namespace

std::string report_text(const Report& report, std::size_t columns, bool colour) {
    Page page(columns, colour);
    if (report.machine) {
        page.paragraph("", machine_line(*report.machine));
        if (report.ports.empty()) {
            page.paragraph("", "No serial port with hardware.");
        }
    }
    for (const ExaminedPort& port : report.ports) {
        print_port(port, page);
    }
    for (const CanInterface& interface : report.can) {
        page.paragraph("", summary(interface));
    }
    if (report.machine && report.can.empty()) {
        page.paragraph("", "No CAN interface.");
    }
    for (const InputFacts& facts : report.inputs) {
        print_input(facts, page);
    }
    for (const PwmFacts& facts : report.pwm) {
        print_pwm(facts, page);
    }
    if (report.uinput && report.uinput->access.may_open) {
        page.paragraph("", "/dev/uinput: virtual joysticks are possible");
    }
    for (const GpioFacts& facts : report.gpio) {
        print_gpio(facts, page);
    }
    for (const SpiFacts& facts : report.spi) {
        print_spi_port(facts, page);
    }
    std::string text = page.take();
    if (!text.empty() && !report.findings.empty()) {
        text += '\n';
    }
    for (const Finding& finding : report.findings) {
        print_finding(finding, page);
    }
    return text + page.take();
}

}  // namespace tribus::doctor

#include "app/status/metrics_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/status/fields.h"
#include "core/utf8.h"

namespace tribus {
namespace {

using Label = std::pair<std::string_view, std::string_view>;
using OrderedJson = nlohmann::ordered_json;

constexpr double kMicrosecondsASecond = 1e6;

/// Writes metric families one after the other, each with one help and one type line.
class Text {
  public:
    explicit Text(std::string_view daemon) : daemon_(escaped_label(daemon)) {}
    void family(std::string name, std::string_view type, std::string help) {
        name_ = std::move(name);
        type_ = type;
        help_ = std::move(help);
    }
    void sample(const std::vector<Label>& labels, double value) {
        if (name_ != begun_) {
            text_ +=
                fmt::format("# HELP tribus_{0} {1}\n# TYPE tribus_{0} {2}\n", name_, help_, type_);
            begun_ = name_;
        }
        text_ += fmt::format("tribus_{}{{daemon=\"{}\"", name_, daemon_);
        for (const auto& [label, content] : labels) {
            text_ += fmt::format(",{}=\"{}\"", label, escaped_label(content));
        }
        text_ += "} ";
        text_ += std::isnan(value)   ? std::string("NaN")
                 : std::isinf(value) ? std::string(value > 0 ? "+Inf" : "-Inf")
                                     : fmt::format("{}", value);
        text_ += '\n';
    }
    std::string take() { return std::move(text_); }

  private:
    std::string daemon_;
    std::string text_;
    std::string name_;
    std::string_view type_;
    std::string help_;
    std::string begun_;
};

/// Times are in seconds there.
double number_of(const StatusField& field, const OrderedJson& value) {
    return value.is_boolean()              ? (value.get<bool>() ? 1 : 0)
           : field.kind == FieldKind::time ? value.get<double>() / kMicrosecondsASecond
                                           : value.get<double>();
}

/// Quantiles of no values are no numbers: as 0 an output that sends nothing would look punctual.
void add_quantiles(Text& text, Label part, const OrderedJson& distribution) {
    constexpr std::array<std::pair<std::string_view, const char*>, 3> kQuantiles{
        {{"0.5", "p50_us"}, {"0.99", "p99_us"}, {"1", "max_us"}}};
    for (const auto& [word, member] : kQuantiles) {
        text.sample({part, {"quantile", word}},
                    distribution["count"] == 0
                        ? std::numeric_limits<double>::quiet_NaN()
                        : distribution[member].get<double>() / kMicrosecondsASecond);
    }
}

/// A counter that the status does not tell yet is 0: a rate needs its first value.
void add_counters(Text& text, const StatusField& field, Label part, const OrderedJson& value) {
    for (const std::string_view word : field.options.words) {
        text.sample({part, {field.options.metric_label, word}}, value.value(word, 0.0));
    }
    for (const auto& [word, count] : value.items()) {
        if (field.options.words.empty()) {
            text.sample({part, {field.options.metric_label, word}}, count.get<double>());
        }
    }
}

void add_samples(Text& text, const StatusField& field, const std::vector<Label>& labels,
                 const OrderedJson& value) {
    switch (field.kind) {
        case FieldKind::word:
            for (const std::string_view word : field.options.words) {
                text.sample({labels.front(), {field.name, word}},
                            value.get_ref<const std::string&>() == word ? 1 : 0);
            }
            break;
        case FieldKind::counters:
            add_counters(text, field, labels.front(), value);
            break;
        case FieldKind::distribution:
            add_quantiles(text, labels.front(), value);
            break;
        default:
            text.sample(labels, number_of(field, value));
            break;
    }
}

void add_program(Text& text, const StatusReport& report) {
    for (const StatusField& field : program_fields()) {
        const OrderedJson value = field.read({report, 0});
        if (const std::string metric = metric_of(field); !metric.empty() && !value.is_null()) {
            text.family(metric, metric_type(field), plain_text(field.help));
            add_samples(text, field, {}, value);
        }
    }
}

void add_parts(Text& text, const StatusReport& report, const PartKind& kind) {
    for (const StatusField& field : kind.fields) {
        const std::string metric = metric_of(field);
        if (metric.empty()) {
            continue;
        }
        text.family(fmt::format("{}_{}", kind.word, metric), metric_type(field),
                    plain_text(field.help));
        for (std::size_t index = 0; index < kind.count(report); ++index) {
            const StatusPart part{report, index};
            const std::string_view name = kind.name(part);
            const OrderedJson value = name.empty() ? OrderedJson() : field.read(part);
            if (!value.is_null() && !value.is_discarded()) {
                add_samples(text, field, {{kind.label, name}}, value);
            }
        }
    }
}

/// The age goes on where the value is left out: so a value that became stale can be told from one
/// that never was.
void add_values(Text& text, const StatusReport& report) {
    const auto labels = [](const ValueReport& value) {
        return std::vector<Label>{{"name", value.value.name}, {"unit", value.value.unit}};
    };
    text.family("value", "gauge", "a named value that is not stale, in its own unit");
    for (const ValueReport& value : report.values) {
        if (is_fresh(value, report.now)) {
            text.sample(labels(value), value.status.number);
        }
    }
    text.family("value_age_seconds", "gauge",
                "time since the source of a named value last gave it, stale or not");
    for (const ValueReport& value : report.values) {
        if (value.status.ever) {
            const Duration age = report.now - value.status.at;
            text.sample(labels(value), std::chrono::duration<double>(age).count());
        }
    }
}

}  // namespace

/// Backslash, quote and line feed are escaped (text format 0.0.4, "Line format"). A scraper refuses
/// all of a text that is not UTF-8, so a byte of something else is shown as \xE4.
std::string escaped_label(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        const char first = text.front();
        if (length == 0) {
            out += fmt::format("\\\\x{:02X}", static_cast<unsigned char>(first));
        } else if (first == '\n') {
            out += "\\n";
        } else {
            out += first == '\\' || first == '"' ? "\\" : "";
            out += text.substr(0, length);
        }
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return out;
}

std::string metrics_text(const StatusReport& report) {
    Text text(name_of(report));
    add_program(text, report);
    for (const PartKind& kind : part_kinds()) {
        add_parts(text, report, kind);
    }
    add_values(text, report);
    return text.take();
}

}  // namespace tribus

#include <cstddef>
#include <string_view>

#include <fmt/format.h>

#include "app/status/field_tables.h"
#include "app/status/field_values.h"

namespace tribus::value_fields {
namespace {

using namespace field_values;

OrderedJson number(const StatusPart& part) {
    return of<ValueReport>(part).status.ever ? finite(of<ValueReport>(part).status.number)
                                             : OrderedJson();
}
OrderedJson number_age(const StatusPart& part) {
    return of<ValueReport>(part).status.ever ? age(of<ValueReport>(part).status.at, part.report.now)
                                             : OrderedJson();
}
OrderedJson text(const StatusPart& part) {
    const ValueReport& value = of<ValueReport>(part);
    if (!value.status.ever) {
        return "never came";
    }
    return fmt::format("{}{:.6g} {}",
                       is_fresh(value, part.report.now) ? "" : "stale: ", value.status.number,
                       value.value.unit);
}
OrderedJson stale(const StatusPart& part) {
    return !is_fresh(of<ValueReport>(part), part.report.now);
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&NamedValue::name>},
    {"number",
     FieldKind::amount,
     "the latest, stale or not",
     number,
     {.may_be_null = true, .fleet = "number"}},
    {"unit", FieldKind::text, "as configured", member<&NamedValue::unit>, {.fleet = "unit"}},
    {"age_us",
     FieldKind::time,
     "time since its source last gave it; `null`: it never did",
     number_age,
     {.may_be_null = true, .fleet = "age_s"}},
    {"text", FieldKind::text, "the number with its unit, or that it is stale", text},
    {"stale", FieldKind::flag, "its number says nothing about now", stale},
};

}  // namespace

constexpr PartKind kKind{
    "values",
    "value",
    "name",
    "values",
    kFields,
    [](const StatusReport& all) { return all.values.size(); },
    [](const StatusPart& part) -> std::string_view { return of<ValueReport>(part).value.name; }};

}  // namespace tribus::value_fields

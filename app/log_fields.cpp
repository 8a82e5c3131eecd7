#include "app/log_fields.h"

namespace tribus {
namespace {

thread_local std::array<LogField, LogFields::kMost> fields;

}  // namespace

LogFields::LogFields(LogField first, LogField second) {
    fields = {first, second};
}

LogFields::~LogFields() {
    fields = {};
}

const std::array<LogField, LogFields::kMost>& LogFields::current() {
    return fields;
}

}  // namespace tribus

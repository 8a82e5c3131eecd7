#include "app/journal/log_fields.h"

namespace tribus {
namespace {

thread_local std::array<LogField, LogFields::kMost> fields_of_thread;

}  // namespace

LogFields::LogFields(LogField first, LogField second) {
    fields_of_thread = {first, second};
}

LogFields::~LogFields() {
    fields_of_thread = {};
}

const std::array<LogField, LogFields::kMost>& LogFields::current() {
    return fields_of_thread;
}

}  // namespace tribus

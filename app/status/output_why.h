#pragma once

#include <string>

#include "app/status/fields.h"
#include "config/schema/schema.h"

namespace tribus {

/// The failsafe of an output. Null for one without a pipeline: it sends values only. Pure.
const FailsafeSettings* failsafe_of(const StatusPart& part);

/// Why an output is not under control, as one sentence: what it sends meanwhile, what it waits for,
/// and what its other inputs lack. For an output in control: which inputs are not good. Pure.
std::string output_why(const StatusPart& part);

}  // namespace tribus

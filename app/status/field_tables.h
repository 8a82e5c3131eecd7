#pragma once

#include "app/status/fields.h"

/// The tables behind `part_kinds` and `program_fields`, each beside its functions that read.
namespace tribus {

namespace input_fields {
extern const PartKind kKind;
}
namespace output_fields {
extern const PartKind kKind;
}
namespace pipeline_fields {
extern const PartKind kKind;
}
namespace port_fields {
extern const PartKind kKind;
}
/// A CAN interface is a port that has more fields.
namespace can_fields {
extern const PartKind kKind;
}
namespace line_fields {
extern const PartKind kKind;
}
namespace sensor_bus_fields {
extern const PartKind kKind;
}
namespace node_fields {
extern const PartKind kKind;
}
namespace value_fields {
extern const PartKind kKind;
}

}  // namespace tribus

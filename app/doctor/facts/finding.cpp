#include "app/doctor/facts/finding.h"

namespace tribus::doctor {

std::string_view severity_name(Severity severity) {
    switch (severity) {
        case Severity::problem:
            return "problem";
        case Severity::advice:
            return "advice";
        case Severity::note:
            break;
    }
    return "note";
}

}  // namespace tribus::doctor

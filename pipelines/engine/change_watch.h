#pragma once

#include <cstddef>

#include "core/time.h"

namespace tribus {

/// Is told at once when the state of an input or output changes.
class ChangeWatch {
  public:
    virtual void input_changed(std::size_t input, Instant now) = 0;
    virtual void output_changed(std::size_t output, Instant now) = 0;

  protected:
    ~ChangeWatch() = default;
};

}  // namespace tribus

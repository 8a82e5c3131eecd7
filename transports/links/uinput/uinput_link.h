#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "core/joystick_report.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A joystick that exists as long as this link. Thread-bound. No heap after `open`.
class UinputLink final : public ByteLink {
  public:
    static constexpr std::size_t kLongestName = 79;

    /// The error says what to do.
    static tl::expected<std::unique_ptr<UinputLink>, std::string> open(const std::string& name);
    /// Whether the kernel has no uinput now; its module may be loaded later.
    static bool is_missing(const std::string& name);

    /// Nothing arrives.
    ReadStatus read(Reception& reception) override;
    /// Writes a report of kJoystickReportBytes: what changed since the one before.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override {}
    int descriptor() const override { return -1; }

  private:
    explicit UinputLink(UniqueFd fd) : fd_(std::move(fd)) {}

    UniqueFd fd_;
    std::array<std::uint8_t, kJoystickReportBytes> before_{};
    bool wrote_ = false;
};

}  // namespace tribus

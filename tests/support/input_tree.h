#pragma once

#include <linux/input-event-codes.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/support/kernel_tree.h"

namespace tribus::test {

/// A KernelTree with the files that the kernel makes of input devices.
class InputTree : public KernelTree {
  public:
    /// ABS_X, ABS_Y, ABS_RX, ABS_RY; BTN_SOUTH, BTN_EAST, BTN_TL.
    void add_pad(const std::string& event, const std::string& name) const {
        add(event, name, {ABS_X, ABS_Y, ABS_RX, ABS_RY}, {BTN_SOUTH, BTN_EAST, BTN_TL});
    }
    void add_keyboard(const std::string& event) const {
        add(event, "Keyboard", {}, {KEY_ESC, KEY_A, KEY_SPACE});
    }
    void add(const std::string& event, const std::string& name, const std::vector<int>& axes,
             const std::vector<int>& keys) const {
        const std::string device = "sys/class/input/" + event + "/device/";
        write(device + "name", name + "\n");
        write(device + "uniq", "\n");
        write(device + "capabilities/abs", words_of(axes) + "\n");
        write(device + "capabilities/key", words_of(keys) + "\n");
        write("dev/input/" + event, "");
    }

  private:
    /// A set as the kernel writes it: words of its `unsigned long`, the highest first.
    static std::string words_of(const std::vector<int>& codes) {
        constexpr int kBits = 8 * sizeof(unsigned long);
        const int most = codes.empty() ? 0 : *std::ranges::max_element(codes);
        std::vector<unsigned long> words(static_cast<std::size_t>(most / kBits) + 1);
        for (const int code : codes) {
            words[static_cast<std::size_t>(code / kBits)] |= 1UL << code % kBits;
        }
        std::ranges::reverse(words);
        return fmt::format("{:x}", fmt::join(words, " "));
    }
};

}  // namespace tribus::test

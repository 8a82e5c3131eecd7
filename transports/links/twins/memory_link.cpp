#include "transports/links/twins/memory_link.h"

#include <algorithm>

namespace tribus {

ReadStatus MemoryLink::read(Reception& reception) {
    reception.count = 0;
    reception.damaged.reset();
    reception.full = false;
    if (lost_) {
        return ReadStatus::lost;
    }
    while (waiting_ > 0 && reception.count < reception.bytes.size()) {
        reception.bytes[reception.count] = sent_[first_];
        reception.damaged.set(reception.count, damaged_.test(first_));
        ++reception.count;
        first_ = (first_ + 1) % kCapacity;
        --waiting_;
    }
    reception.full = reception.count == reception.bytes.size();
    return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
}

WriteStatus MemoryLink::write(std::span<const std::uint8_t> frame) {
    if (lost_) {
        return WriteStatus::lost;
    }
    if (busy_ || frame.size() > kCapacity - written_count_) {
        return WriteStatus::busy;
    }
    std::copy(frame.begin(), frame.end(), written_.begin() + static_cast<long>(written_count_));
    written_count_ += frame.size();
    ++frames_written_;
    return WriteStatus::written;
}

std::size_t MemoryLink::send(std::span<const std::uint8_t> bytes) {
    std::size_t taken = 0;
    while (taken < bytes.size() && push(bytes[taken], false)) {
        ++taken;
    }
    return taken;
}

std::size_t MemoryLink::send(const Reception& bytes) {
    std::size_t taken = 0;
    while (taken < bytes.count && push(bytes.bytes[taken], bytes.damaged.test(taken))) {
        ++taken;
    }
    return taken;
}

bool MemoryLink::send_damaged(std::uint8_t byte) {
    return push(byte, true);
}

void MemoryLink::clear_written() {
    written_count_ = 0;
    frames_written_ = 0;
}

void MemoryLink::set_lost(bool lost) {
    lost_ = lost;
    if (lost) {
        waiting_ = 0;
    }
}

bool MemoryLink::push(std::uint8_t byte, bool damaged) {
    if (lost_ || waiting_ == kCapacity) {
        return false;
    }
    const std::size_t place = (first_ + waiting_) % kCapacity;
    sent_[place] = byte;
    damaged_.set(place, damaged);
    ++waiting_;
    return true;
}

}  // namespace tribus

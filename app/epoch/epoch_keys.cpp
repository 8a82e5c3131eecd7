#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <vector>

#include "app/epoch/epoch_file.h"
#include "transports/codecs/authenticated/broadcast.h"

/// The numbers of each key of a receiver.
namespace tribus {
namespace {

constexpr const NumberBlocks& kBlocks = authenticated::BroadcastReceiver::kNumbers;

/// The keys of the latest changes. Of earlier ones nothing is kept.
constexpr std::size_t kMostKeys = 4;

}  // namespace

EpochFile::OfKey::OfKey(EpochFile& file, std::uint32_t id, std::uint64_t first)
    : file_(file), id_(id) {
    begin_at(first, first);
}

void EpochFile::OfKey::begin_at(std::uint64_t first, std::uint64_t wanted) {
    begin(first);
    reserved_.store(first);
    wanted_.store(std::min(wanted, kEndOfNumbers));
}

void EpochFile::OfKey::want(std::uint64_t end) {
    wanted_.store(std::max(end, wanted()), std::memory_order_relaxed);
    file_.ask_to_store();
}

/// Before `open` the number of its beginning is not known.
NumberReservation& EpochFile::of_key(std::uint32_t id) {
    const std::lock_guard guard(mutex_);
    auto known = std::ranges::find(keys_, id, &OfKey::id);
    if (known == keys_.end()) {
        known = keys_.emplace(keys_.end(), *this, id, first_of_keys_);
    }
    keys_.splice(keys_.end(), keys_, known);
    return *known;
}

/// Reserves the first ones of the keys that the configuration has.
void EpochFile::begin_keys(const Content& stored) {
    const std::lock_guard guard(mutex_);
    first_of_keys_ = stored.next;
    for (OfKey& key : keys_) {
        key.begin_at(stored.next, stored.next + kBlocks.block);
    }
    const auto asked_first = keys_.begin();
    for (const KeyNumber& of_file : stored.keys) {
        const auto known = std::ranges::find(keys_, of_file.id, &OfKey::id);
        if (known != keys_.end()) {
            known->begin_at(of_file.number, of_file.number + kBlocks.block);
        } else {
            keys_.emplace(asked_first, *this, of_file.id, of_file.number);
        }
    }
}

/// Does for the numbers of keys what `take_up_again` does.
void EpochFile::take_up_keys_again() {
    const std::lock_guard guard(mutex_);
    for (OfKey& key : keys_) {
        key.begin_at(key.next(), key.next() + kBlocks.block);
    }
}

/// Returns the numbers of the keys that are to be stored.
std::vector<EpochFile::KeyNumber> EpochFile::ends_of_keys(bool ended) {
    const std::lock_guard guard(mutex_);
    std::vector<KeyNumber> ends;
    auto key = keys_.begin();
    std::advance(key, keys_.size() > kMostKeys ? keys_.size() - kMostKeys : 0);
    for (; key != keys_.end(); ++key) {
        ends.push_back({key->id(), ended ? key->next() : key->wanted()});
    }
    return ends;
}

}  // namespace tribus

#include "transports/codecs/dbc/message_map.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "core/quotes.h"
#include "transports/codecs/dbc/signal.h"
#include "transports/codecs/dbc/signal_map.h"

namespace tribus {
namespace {

using Path = std::vector<std::string>;
using Mistakes = std::vector<SettingMistake>;
using Data = std::array<std::uint8_t, kMostFdBytes>;

constexpr std::uint32_t kWithoutPriority = 0x03FF'FFFF;
constexpr std::uint32_t kWithoutSource = 0x03FF'FF00;
constexpr std::uint32_t kSourceAddress = 0xFF;
/// No node may send from this address. In DBC files it stands for "any source".
constexpr std::uint32_t kNullAddress = 0xFE;

constexpr const char* kNotReceived =
    "\"from\" sends a named value, but this is an input; allowed: in the signals of an output; "
    "[values.NAME] makes named values of the signals of a message";

/// The values of the selectors in a sent frame: the first selecting value of each.
using Page = std::vector<std::pair<const DbcSignal*, std::uint64_t>>;

Page page_of(const DbcConditions& conditions) {
    Page page;
    for (const DbcCondition& condition : conditions) {
        page.emplace_back(condition.selector, condition.selected_by.front().first);
    }
    return page;
}

bool starts_with(const Page& page, const Page& beginning) {
    return beginning.size() < page.size() &&
           std::equal(beginning.begin(), beginning.end(), page.begin());
}

/// Builds the mapping of one message from the roles of its signals.
class MessageBuilder {
  public:
    MessageBuilder(const DbcMessage& message, const DbcEnd& end, DbcMap& map, Mistakes& mistakes)
        : message_(message),
          scope_(end.scope),
          own_address_(end.own_address),
          map_(map),
          mistakes_(mistakes) {}

    void build(const SettingTree::Table& roles, const Path& path) {
        const std::size_t before = mistakes_.size();
        for (const SettingEntry& entry : roles) {
            Path signal_path = path;
            signal_path.push_back(entry.key);
            if (auto mapped = map_dbc_signal(message_, entry, signal_path, mistakes_)) {
                if (scope_ == SettingScope::input &&
                    std::holds_alternative<DbcValue>(mapped->use)) {
                    signal_path.emplace_back("from");
                    complain(signal_path, kNotReceived);
                }
                mapped_.push_back(std::move(*mapped));
            }
        }
        choose_pages();
        check_message(roles, path);
        if (mistakes_.size() > before) {
            return;
        }
        const DbcMappedMessage described = describe();
        for (DbcPart& part : scope_ == SettingScope::output ? sent_parts() : received_parts()) {
            map_.parts.push_back(std::move(part));
        }
        map_.messages.push_back(described);
    }

  private:
    void complain(const Path& path, std::string text) {
        mistakes_.push_back({path, std::move(text)});
    }

    /// A fixed selector says which page is meant.
    void choose_pages() {
        for (std::size_t at = 0; at < mapped_.size();) {
            const auto* fixed = std::get_if<DbcFixed>(&mapped_[at].use);
            if (fixed != nullptr && choose_page(mapped_[at], fixed->bits)) {
                mapped_.erase(mapped_.begin() + static_cast<std::ptrdiff_t>(at));
            } else {
                ++at;
            }
        }
    }

    /// Returns whether other mapped signals depend on the selector.
    bool choose_page(const DbcMappedSignal& selector, std::uint64_t page) {
        bool selects = false;
        for (DbcMappedSignal& signal : mapped_) {
            for (DbcCondition& condition : signal.conditions) {
                if (condition.selector != selector.signal) {
                    continue;
                }
                selects = true;
                if (std::ranges::none_of(condition.selected_by, [page](const auto& range) {
                        return range.first <= page && page <= range.last;
                    })) {
                    complain(selector.path, off_page(*selector.signal, *signal.signal, page));
                    return true;
                }
                condition.selected_by = {{page, page}};
            }
        }
        return selects;
    }

    std::string off_page(const DbcSignal& selector, const DbcSignal& signal,
                         std::uint64_t page) const {
        return in_quotes(selector.name) + " is fixed to the page " + std::to_string(page) +
               ", but " + in_quotes(signal.name) +
               " is on another one; allowed: the signals of one page, or leave " +
               in_quotes(selector.name) +
               (scope_ == SettingScope::output ? " out: then each page is sent in turn"
                                               : " out: then each page is read");
    }

    /// A message without data, such as SYNC of CANopen, is sent as it is.
    bool may_be_bare() const { return scope_ == SettingScope::output && message_.length == 0; }

    void check_message(const SettingTree::Table& roles, const Path& path) {
        if (roles.empty() && !may_be_bare()) {
            complain(path,
                     "no signal of the message has a role; allowed: at least one, such as "
                     "SIGNAL = 1 or SIGNAL = { fixed = 5 }");
        }
        if (scope_ == SettingScope::output && leaves_source_open(message_) && !own_address_) {
            complain(path,
                     "the id of the message has the source address 0xFE, from which no node "
                     "may send; add own_address = 0 to 253, the address of this node, to the "
                     "output");
        }
        check_alone<DbcCounter>("the message already has a counter; allowed: one");
        check_alone<DbcChecksum>("the message already has a checksum; allowed: one");
    }

    template <class Use>
    void check_alone(const char* text) {
        bool found = false;
        for (const DbcMappedSignal& signal : mapped_) {
            if (std::holds_alternative<Use>(signal.use) && std::exchange(found, true)) {
                complain(signal.path, text);
            }
        }
    }

    DbcMappedMessage describe() const {
        DbcMappedMessage mapped;
        mapped.name = message_.name;
        mapped.sent_id = message_.id;
        mapped.id = received_ids(message_);
        if (scope_ == SettingScope::output && leaves_source_open(message_) && own_address_) {
            mapped.sent_id = (message_.id & ~kSourceAddress) | *own_address_;
            mapped.id.id = mapped.sent_id;
            mapped.id.mask = kWithoutPriority;
        }
        mapped.fd = message_.fd;
        mapped.bit_rate_switch = message_.bit_rate_switch;
        mapped.length = static_cast<std::uint8_t>(message_.length);
        mapped.fill = fill();
        mapped.cycle = message_.cycle_time;
        for (const DbcMappedSignal& signal : mapped_) {
            if (const auto* counter = std::get_if<DbcCounter>(&signal.use)) {
                mapped.counter = *counter;
            } else if (const auto* checksum = std::get_if<DbcChecksum>(&signal.use)) {
                mapped.checksum = *checksum;
            }
        }
        return mapped;
    }

    /// J1939 fills unused bits with ones: "not available".
    std::uint8_t fill() const { return message_.j1939 ? 0xFF : 0x00; }

    std::vector<DbcPart> received_parts() const {
        std::vector<DbcPart> parts;
        std::vector<DbcConditions> known;
        for (const DbcMappedSignal& signal : mapped_) {
            auto at = std::ranges::find(known, signal.conditions);
            if (at == known.end()) {
                known.push_back(signal.conditions);
                at = known.end() - 1;
                parts.push_back(empty_part(page_of(signal.conditions)));
                for (std::size_t i = 0; i < signal.conditions.size(); ++i) {
                    parts.back().selectors[i].selected_by = signal.conditions[i].selected_by;
                }
            }
            add(signal, parts[static_cast<std::size_t>(at - known.begin())]);
        }
        return parts;
    }

    std::vector<DbcPart> sent_parts() {
        std::vector<DbcPart> parts;
        for (const Page& page : pages()) {
            parts.push_back(sent_part(page));
        }
        return parts;
    }

    /// The deepest pages. Signals of outer pages are in each page below.
    std::vector<Page> pages() const {
        std::vector<Page> pages;
        if (mapped_.empty()) {
            pages.emplace_back();
        }
        for (const DbcMappedSignal& signal : mapped_) {
            Page page = page_of(signal.conditions);
            const bool deeper = std::ranges::any_of(mapped_, [&](const DbcMappedSignal& other) {
                return starts_with(page_of(other.conditions), page);
            });
            if (!deeper && std::ranges::find(pages, page) == pages.end()) {
                pages.push_back(std::move(page));
            }
        }
        return pages;
    }

    DbcPart empty_part(const Page& page) const {
        DbcPart part;
        part.message = map_.messages.size();
        for (const auto& [selector, value] : page) {
            part.selectors.push_back({DbcLayout(*selector), {{value, value}}, value});
        }
        return part;
    }

    /// Contains every mapped signal that a receiver of this frame will find in it: it would read a
    /// left-out signal from whatever bits are there.
    DbcPart sent_part(const Page& page) {
        DbcPart part = empty_part(page);
        Data data;
        data.fill(fill());
        Data taken{};
        for (const DbcSelector& selector : part.selectors) {
            selector.layout.set_raw_bits(data, selector.sent);
            selector.layout.set_raw_bits(taken, ~std::uint64_t{0});
        }
        const auto frame = std::span(data).first(message_.length);
        for (const DbcMappedSignal& signal : mapped_) {
            if (present(message_, *signal.signal, frame)) {
                add(signal, part);
                take_bits(signal, taken);
            }
        }
        return part;
    }

    void take_bits(const DbcMappedSignal& signal, Data& taken) {
        bool free = take_bits(DbcLayout(*signal.signal), taken);
        if (const auto* channel = std::get_if<DbcChannel>(&signal.use)) {
            for (const auto& status : {channel->negative, channel->positive, channel->neutral}) {
                free = (!status || take_bits(*status, taken)) && free;
            }
        }
        const bool reported =
            std::ranges::find(mistakes_, signal.path, &SettingMistake::path) != mistakes_.end();
        if (!free && !reported) {
            complain(signal.path,
                     "its bits overlap those of another signal in the same "
                     "frame; allowed: signals that do not overlap");
        }
    }

    /// Whether all bits were free.
    static bool take_bits(const DbcLayout& layout, Data& taken) {
        Data own{};
        layout.set_raw_bits(own, ~std::uint64_t{0});
        bool free = true;
        for (std::size_t i = 0; i < own.size(); ++i) {
            free = free && (taken[i] & own[i]) == 0;
            taken[i] |= own[i];
        }
        return free;
    }

    static void add(const DbcMappedSignal& signal, DbcPart& part) {
        if (const auto* channel = std::get_if<DbcChannel>(&signal.use)) {
            part.channels.push_back(*channel);
        } else if (const auto* flag = std::get_if<DbcFlag>(&signal.use)) {
            part.flags.push_back(*flag);
        } else if (const auto* fixed = std::get_if<DbcFixed>(&signal.use)) {
            part.fixed.push_back(*fixed);
        } else if (const auto* value = std::get_if<DbcValue>(&signal.use)) {
            part.values.push_back(*value);
        }
    }

    const DbcMessage& message_;
    SettingScope scope_;
    std::optional<std::uint8_t> own_address_;
    DbcMap& map_;
    Mistakes& mistakes_;
    std::vector<DbcMappedSignal> mapped_;
};

}  // namespace

bool leaves_source_open(const DbcMessage& message) {
    return message.j1939 && (message.id & kSourceAddress) == kNullAddress;
}

CanIdMatch received_ids(const DbcMessage& message) {
    CanIdMatch ids{.id = message.id, .extended = message.extended};
    if (message.j1939) {
        ids.mask = leaves_source_open(message) ? kWithoutSource : kWithoutPriority;
    }
    return ids;
}

void map_dbc_message(const DbcMessage& message, const SettingTree::Table& roles,
                     const std::vector<std::string>& path, const DbcEnd& end, DbcMap& map,
                     std::vector<SettingMistake>& mistakes) {
    MessageBuilder(message, end, map, mistakes).build(roles, path);
}

}  // namespace tribus

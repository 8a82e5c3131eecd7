#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/epoch/clock_run.h"
#include "core/number_reservation.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// The file of `epoch`: below which number one end of a link may have used all of them. Its lines
/// are `tribus epoch 1` and `next NUMBER`. That of a receiver has `key ID NUMBER` for each key,
/// with ID in hexadecimal digits; `next` is for keys that it does not name. That of a sender has
/// `clock RUN ASLEEP ZERO`: the ClockRun, its time asleep in ns, and the number of step 0 of the
/// clock, so that a sender that starts again goes on by the same clock. While the program runs, the
/// number in the file is the end of what is reserved, and after it ended the exact one. The data
/// thread uses the numbers; a thread of its own writes the file, so that nobody waits for a slow
/// disk: neither a link that runs, nor a reload that ends it. Thread-bound to the main thread,
/// unless a function says otherwise.
class EpochFile final : public NumberReservation {
  public:
    /// It has no numbers until `open`. In one process a path has one of these at a time, so that a
    /// number is used once, also where one configuration comes after another. When its last user
    /// has gone, it stores the least number that was not used, closes, and nobody waits for that;
    /// who wants it meanwhile gets the same. Any thread.
    static std::shared_ptr<EpochFile> of(const std::string& path);
    /// Waits until those without a user are closed, for at most `longest`. The end of the program
    /// does so too, for at most `kLongestEnd`. Returns whether they are. Any thread.
    static bool wait_until_closed(Duration longest);
    static constexpr Duration kLongestEnd = std::chrono::seconds(3);
    ~EpochFile() override;

    /// Reads the file, keeps others from using it, and reserves the first numbers of a link's
    /// input or output. A file that is missing is made. Blocks until it is on the disk. No effect
    /// if it is open. The error is a sentence. Any thread.
    tl::expected<void, std::string> open(SettingScope way);
    /// For the data thread.
    std::uint64_t at(std::uint64_t step) override {
        return zero_.load(std::memory_order_acquire) + step;
    }
    NumberReservation& of_key(std::uint32_t id) override;
    /// Logs if the file is in memory, cannot be written any more, or can again. After a suspend a
    /// sender's numbers follow a new clock. Call it a few times a second. `run`: of now.
    void look(const ClockRun& run = clock_run());

  private:
    /// The numbers of one key of a receiver.
    class OfKey final : public NumberReservation {
      public:
        OfKey(EpochFile& file, std::uint32_t id, std::uint64_t first);
        std::uint64_t at(std::uint64_t step) override { return file_.at(step); }
        std::uint32_t id() const { return id_; }
        /// Before the first `use`.
        void begin_at(std::uint64_t first, std::uint64_t wanted);
        /// The end of what was asked for.
        std::uint64_t wanted() const { return wanted_.load(std::memory_order_relaxed); }
        void stored(std::uint64_t end) { reserved_.store(end, std::memory_order_release); }

      private:
        std::uint64_t reserved() const override {
            return reserved_.load(std::memory_order_acquire);
        }
        void want(std::uint64_t end) override;

        EpochFile& file_;
        std::uint32_t id_;
        std::atomic<std::uint64_t> reserved_{0};
        std::atomic<std::uint64_t> wanted_{0};
    };
    struct KeyNumber {
        std::uint32_t id = 0;
        std::uint64_t number = 0;
    };
    /// The numbers and the clock that a file names.
    struct Content {
        std::uint64_t next = 0;
        std::vector<KeyNumber> keys{};
        ClockRun run{};
        std::uint64_t zero = 0;
    };

    struct Registry;
    static Registry& registry();
    static void let_go(const std::string& path);

    explicit EpochFile(std::string path);
    void take_up_again();
    std::uint64_t reserved() const override { return reserved_.load(std::memory_order_acquire); }
    void want(std::uint64_t end) override;
    void ask_to_store();
    tl::expected<void, std::string> lock();
    static std::optional<Content> content_of(std::string_view text);
    tl::expected<Content, std::string> read(SettingScope way) const;
    void begin_after(const Content& stored, SettingScope way);
    void set_clock(std::uint64_t number, std::uint64_t step);
    std::string clock_line();
    void begin_keys(const Content& stored);
    void take_up_keys_again();
    std::vector<KeyNumber> ends_of_keys(bool ended);
    tl::expected<void, std::string> store(std::uint64_t end, bool ended = false);
    tl::expected<void, std::string> start_thread();
    static void* main(void* self);
    void store_until_closed();
    void wait_for_work(Duration longest) const;
    void signal() const;
    void store_wanted();
    bool close();

    std::string path_;
    std::mutex opening_;
    UniqueFd lock_;            ///< valid: it is open
    std::uint64_t block_ = 0;  ///< numbers that are reserved at a time
    std::atomic<std::uint64_t> reserved_{0};
    std::atomic<std::uint64_t> zero_{0};  ///< the number of step 0, modulo 2^64
    std::atomic<std::uint64_t> wanted_{0};
    std::list<OfKey> keys_;            ///< those of this run last; under `mutex_`
    std::uint64_t first_of_keys_ = 0;  ///< that the file does not name; under `mutex_`

    /// Who sets it wakes the file's thread, which clears it.
    std::atomic<bool> storing_{false};
    std::atomic<bool> ends_{false};  ///< likewise
    UniqueFd work_;                  ///< readable: the thread is to look at both
    std::mutex mutex_;
    std::string error_;              ///< of the latest writing; under `mutex_`
    std::optional<ClockRun> run_{};  ///< of a sender's numbers; under `mutex_`
    bool told_failure_ = false;
    std::atomic<bool> is_in_memory_{false};  ///< and that was not told yet
    bool has_thread_ = false;
};

}  // namespace tribus

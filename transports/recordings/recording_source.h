#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/time_steps.h"

namespace tribus {

/// Takes the content of a recording in its order.
class RecordingTaker {
  public:
    RecordingTaker() = default;
    RecordingTaker(const RecordingTaker&) = delete;
    RecordingTaker& operator=(const RecordingTaker&) = delete;
    virtual ~RecordingTaker() = default;

    /// `index`: number of the burst. One burst may come in several pieces.
    virtual void feed_burst(std::size_t /*index*/, const Burst& /*burst*/) {}
    virtual void feed_frame(const RecordedCanFrame& /*frame*/) {}
};

/// Gives a recording to several takers, which must outlive it, in one pass.
class SeveralTakers final : public RecordingTaker {
  public:
    void add(RecordingTaker& taker) { takers_.push_back(&taker); }
    void feed_burst(std::size_t index, const Burst& burst) override;
    void feed_frame(const RecordedCanFrame& frame) override;

  private:
    std::vector<RecordingTaker*> takers_;
};

/// A recording that is read from its start as often as needed. Thread-bound.
class RecordingSource {
  public:
    RecordingSource() = default;
    RecordingSource(const RecordingSource&) = delete;
    RecordingSource& operator=(const RecordingSource&) = delete;
    virtual ~RecordingSource() = default;

    virtual RecordingKind kind() const = 0;
    /// Gives all of it to `taker`. Returns the facts of a log of CAN frames.
    virtual LogFacts read(RecordingTaker& taker) = 0;
};

/// A recording in memory. It must outlive the object.
class RecordingInMemory final : public RecordingSource {
  public:
    explicit RecordingInMemory(const Recording& recording) : recording_(recording) {}
    RecordingKind kind() const override { return recording_.kind; }
    LogFacts read(RecordingTaker& taker) override;

  private:
    const Recording& recording_;
};

/// A recording of any length, which is parsed each time that it is read.
class RecordingInPieces final : public RecordingSource {
  public:
    /// `content` must outlive it.
    RecordingInPieces(Pieces& content, std::string_view file_name, RecordingKind kind)
        : content_(content), file_(file_name), kind_(kind) {}

    /// Parses all of it. Returns the first error as `file:line:column: text`.
    tl::expected<void, std::string> judge();
    /// The interfaces in a log that was judged, in the order in which they first appear.
    const std::vector<std::string>& interfaces() const { return interfaces_; }
    /// Why the rest of a content that was judged is not read, as `file:line:column: text`.
    const std::optional<std::string>& rest() const { return rest_; }
    /// The first gap of more than an hour between two lines of a content that was judged.
    const std::optional<TimeGap>& gap() const { return gaps_.first(); }
    /// The same before its first line.
    const std::optional<TimeGap>& late_start() const { return gaps_.late_start(); }
    /// Leaves out the frames of other interfaces.
    void select_interface(std::string name) { interface_ = std::move(name); }

    RecordingKind kind() const override { return kind_; }
    LogFacts read(RecordingTaker& taker) override;
    /// The mistake at which reading ended, in a file that was changed after it was judged.
    const std::optional<std::string>& failed() const { return failed_; }

  private:
    LogFacts read_log(RecordingTaker& taker);

    Pieces& content_;
    std::string file_;
    RecordingKind kind_;
    std::vector<std::string> interfaces_;
    std::optional<std::string> rest_;
    GapWatch gaps_;
    /// Empty: all are read.
    std::string interface_;
    std::optional<std::string> failed_;
};

}  // namespace tribus

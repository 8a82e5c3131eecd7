#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/appliance/appliance.h"
#include "config/language/mistakes.h"
#include "config/schema/schema.h"

namespace tribus {

/// Result of a Preparation.
struct Prepared {
    std::unique_ptr<Appliance> appliance;  ///< null if only a text was asked for
    std::string text;                      ///< as read; empty if none was
    /// For a draft: the text of the file that it may replace; nothing if that cannot be read.
    std::optional<std::string> file_text{};
};

/// A draft that somebody wants to keep.
struct DraftToKeep {
    std::string path;                      ///< of the configuration
    std::string text;                      ///< of the draft
    std::optional<std::string> file_text;  ///< that of the file when the draft went on trial
};

/// Reads a configuration, builds an appliance from it and opens its files on another thread, so
/// that neither a file of 11 MB nor a disk that does not answer stops the main thread. Thread-bound
/// to the main thread.
class Preparation {
  public:
    using Result = tl::expected<Prepared, std::vector<Mistake>>;

    /// Reads the file as it is now.
    static std::unique_ptr<Preparation> of_file(const std::string& path);
    /// Reads the text of `draft` as if it stood in `path`. Follows no link: others than root may
    /// write drafts, and a message could show what the daemon may read and they may not.
    static std::unique_ptr<Preparation> of_draft(const std::string& draft, const std::string& path);
    /// Lets the file have the text of the draft. If it has another one, its successor
    /// (`write_successor`) takes its place, provided that it has the text of the draft: only who
    /// may write there can have written it. The result is the text that the file has then. It is an
    /// error if somebody changed the file since the draft went on trial.
    static std::unique_ptr<Preparation> keeping(DraftToKeep draft);
    /// Builds an appliance from a configuration that was read before.
    static std::unique_ptr<Preparation> of(const Configuration& configuration);
    Preparation(const Preparation&) = delete;
    Preparation& operator=(const Preparation&) = delete;
    /// Does not wait for its thread, which then goes on and discards its result.
    ~Preparation();

    /// Readable once `done` is true.
    int descriptor() const;
    bool done() const;
    /// True if nothing will have changed: what has not been decided yet is abandoned. False once
    /// the successor of a file may be taking its place, which ends soon.
    bool abandon();
    /// The result. Call it once, when `done` is true.
    Result take();

    /// True if a thread still runs whose result nobody takes. The process must then end without
    /// destroying global objects, which that thread may use.
    static bool any_abandoned();

  private:
    struct Work;
    explicit Preparation(std::shared_ptr<Work> work) : work_(std::move(work)) {}
    static Result appliance_of(std::string text, const std::string& path);
    static std::unique_ptr<Preparation> begin(std::function<Result(Work&)> prepare);
    static void* main(void* given);

    std::shared_ptr<Work> work_;
};

}  // namespace tribus

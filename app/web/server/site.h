#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/client/socket_client.h"
#include "app/web/answers/daemons.h"
#include "app/web/answers/plot_job.h"
#include "app/web/answers/recordings.h"
#include "app/web/http/files.h"
#include "app/web/http/http.h"
#include "app/web/pairing/pairing.h"
#include "core/time.h"

namespace tribus::web {

struct SiteSettings {
    std::filesystem::path configurations;  ///< folder of NAME.toml
    std::filesystem::path state;           ///< folder of PairingFolder, and of the history
    std::filesystem::path page;            ///< folder of the built page
    std::vector<std::string> hosts;        ///< further names of this machine
    bool is_public = false;                ///< the network can reach the page
    std::string ports;                     ///< socket of the helper for ports; empty: a child
    bool metrics = false;                  ///< metrics are for everybody who reaches the page
    std::string version;
};

/// Answers what the page asks (docs/web.md). Thread-bound; nothing here waits.
class Site {
  public:
    explicit Site(SiteSettings settings);

    /// Answers the client as far as its requests are whole. Returns false if the client must be
    /// dropped.
    bool answer(SocketClient& client, Instant now);

    /// Readable when `look` has something to do. Reserves room for `room` more.
    std::vector<int> descriptors(std::size_t room) const;
    /// When `look` must be called at the latest.
    Instant due() const;
    /// Takes what the daemons said.
    void look(Instant now);
    /// Whether a page looks or waits.
    bool in_use() const { return !streams_.empty() || !pending_.empty() || learning_ || plotting_; }

    static constexpr std::size_t kStreamsOfOneBrowser = 4;

  private:
    bool answer_one(SocketClient& client, Instant now);

    struct Visitor {
        Role role;
        std::string hash;  ///< of the cookie
    };
    /// A page that gets each status.
    struct Stream {
        std::string daemon;
        std::string visitor;
        std::uint64_t sent = 0;
        std::string said;  ///< the problem that it was told
        Instant said_at{};
        bool displaced = false;
        Instant looked_for_visitor{};
    };
    /// A draft that this program put on trial.
    struct Draft {
        std::uint64_t trial = 0;
        std::string text;
        std::string before;  ///< fingerprint of the file that it is to replace
    };
    using Late = std::function<std::optional<HttpAnswer>()>;
    using Reply = std::variant<HttpAnswer, Late>;
    using FromLine = std::function<HttpAnswer(const std::string& json)>;
    /// Its answer is worked on also if the page that asked is gone: a file may have to go back.
    struct Pending {
        LineRequest request;
        FromLine as_answer;
        std::optional<HttpAnswer> answer;
    };

    /// A receiver whose loss a person shows, step by step. One at a time.
    struct Learning {
        std::string visitor;
        LineTalk talk;
        Instant end{};
        bool awaits_step = false;
        std::optional<HttpAnswer> step{};
    };

    Reply reply(const HttpRequest& request, Instant now);
    Reply reply_of_api(const HttpRequest& request, std::string_view path, Instant now);
    Reply reply_of_daemon(const HttpRequest& request, const KnownDaemon& daemon,
                          std::string_view what, Role role, Instant now);
    Reply look_at_daemon(const KnownDaemon& daemon, std::string_view what, Instant now);
    std::optional<Reply> judge_draft(const HttpRequest& request, const KnownDaemon& daemon,
                                     std::string_view what, Instant now);
    Reply change_of_daemon(const HttpRequest& request, const KnownDaemon& daemon,
                           std::string_view what, Instant now);
    Reply look_at_recordings(const HttpRequest& request, const KnownDaemon& daemon,
                             std::string_view what, Instant now);
    Reply with_recordings(const KnownDaemon& daemon, Instant now,
                          std::function<Reply(const RecordingsPlace&)> go_on);
    Reply begin_plot(const RecordingsPlace& place, const std::string& name,
                     const std::string& query);
    HttpAnswer file_of_page(const HttpRequest& request) const;
    HttpAnswer me(const HttpRequest& request);
    HttpAnswer daemons(Instant now) const;
    HttpAnswer pair(const HttpRequest& request);
    HttpAnswer leave(const HttpRequest& request);
    Reply metrics_of_daemons(Instant now);
    Reply doctor(const HttpRequest& request, Role role, Instant now);
    Reply learn(const HttpRequest& request, std::string_view verb, const Visitor& visitor,
                Instant now);
    Reply begin_learning(const HttpRequest& request, const Visitor& visitor, Instant now);
    Reply next_step(Instant now);
    void look_at_learning(Instant now);
    /// Whoever waits for a step reads why none comes.
    void end_learning(std::string_view why);
    Reply ask(LineRequest request, FromLine as_answer);
    Reply ask(const KnownDaemon& daemon, std::string_view line, Instant now, FromLine as_answer,
              Duration patience = std::chrono::seconds(5));
    Reply ask_to_change(const KnownDaemon& daemon, std::string_view line, Instant now,
                        FromLine as_answer, Duration patience = std::chrono::seconds(5));
    Reply ask_at(const std::string& socket, std::string_view line, Instant now, FromLine as_answer,
                 Duration patience);
    Reply begin_draft(const HttpRequest& request, const KnownDaemon& daemon, Instant now);
    static std::optional<HttpAnswer> why_not(const HttpRequest& request, const std::string& text,
                                             const KnownDaemon& daemon);
    Reply save(const HttpRequest& request, const KnownDaemon& daemon);
    Reply run_draft(const KnownDaemon& daemon, Draft draft, std::int64_t seconds, Instant now);
    Reply keep_draft(const KnownDaemon& daemon, std::uint64_t trial, Instant now);

    bool begin_stream(SocketClient& client, const HttpRequest& request, std::string daemon,
                      Instant now);
    bool send_to_stream(const std::shared_ptr<Stream>& stream, SocketClient& client, Instant now);
    bool send_reply(SocketClient& client, const HttpRequest& request, Reply reply, Instant now);
    DaemonWatch* watch_of(const std::string& daemon);

    std::string cookie_name(std::string_view host) const;
    std::optional<Visitor> visitor_of(const HttpRequest& request);
    std::optional<Visitor> visitor_with(std::string_view hash);

    SiteSettings settings_;
    PageFiles files_;
    PairingFolder pairing_;
    SessionsInMemory sessions_;
    std::vector<std::string> names_;
    std::list<std::weak_ptr<Stream>> streams_;
    std::map<std::string, std::unique_ptr<DaemonWatch>> watches_;
    std::list<std::shared_ptr<Pending>> pending_;
    std::map<std::string, Draft> drafts_;
    std::shared_ptr<Learning> learning_;
    std::shared_ptr<PlotJob> plotting_;  ///< null while no recording is read
};

}  // namespace tribus::web

#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <tl/expected.hpp>

#include "app/client/socket_client.h"
#include "app/web/answers/daemons.h"
#include "app/web/answers/plot_job.h"
#include "app/web/answers/recordings.h"
#include "app/web/http/files.h"
#include "app/web/http/http.h"
#include "app/web/pairing/pairing.h"
#include "app/web/pairing/pairing_pauses.h"
#include "app/web/server/routes.h"
#include "core/rate_limit.h"
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

    /// All that may be asked beside files of the page, and who may ask it.
    static std::vector<Route> known_routes();

    static constexpr std::size_t kStreamsOfOneBrowser = 4;

  private:
    bool answer_one(SocketClient& client, Instant now);
    bool answer_request(SocketClient& client, const HttpRequest& request, Instant now);

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
        std::string before{};  ///< fingerprint of the file that it is to replace
        bool is_being_kept = false;
    };
    using Late = std::function<std::optional<HttpAnswer>()>;
    using Reply = std::variant<HttpAnswer, Late>;
    using FromLine = std::function<HttpAnswer(const std::string& json)>;
    /// Its answer is worked on also if the page that asked is gone: it may leave a file.
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

    /// A request for a route.
    struct Asked {
        const HttpRequest& request;
        const std::optional<Visitor>& visitor;  ///< set where the route is not for anybody
        const KnownDaemon& daemon;  ///< of the path's first name; empty if the path has none
        const std::string& name;    ///< the path's last name; empty if it has none
        const std::string& who;     ///< see `SocketClient::who`
        Instant now;
    };
    struct SiteRoute {
        Route route;
        Reply (Site::*answer)(const Asked& asked) = nullptr;  ///< null: a stream
    };
    static std::span<const SiteRoute> routes();
    bool answer_route(SocketClient& client, const HttpRequest& request, const SiteRoute& one,
                      const PathNames& names, Instant now);

    Reply me(const Asked& asked);
    Reply pair(const Asked& asked);
    Reply leave(const Asked& asked);
    Reply metrics(const Asked& asked);
    Reply daemons(const Asked& asked);
    Reply doctor(const Asked& asked);
    Reply begin_learning(const Asked& asked);
    Reply go_on_learning(const Asked& asked);
    Reply stop_learning(const Asked& asked);
    Reply status(const Asked& asked);
    Reply changes(const Asked& asked);
    Reply histograms(const Asked& asked);
    Reply configuration(const Asked& asked);
    Reply schema(const Asked& asked);
    Reply running_picture(const Asked& asked);
    Reply history(const Asked& asked);
    Reply kept_file(const Asked& asked);
    Reply recording_state(const Asked& asked);
    Reply recordings(const Asked& asked);
    Reply recording_tar(const Asked& asked);
    Reply recording_plot(const Asked& asked);
    Reply check(const Asked& asked);
    Reply draft_picture(const Asked& asked);
    Reply difference(const Asked& asked);
    Reply begin_draft(const Asked& asked);
    Reply save(const Asked& asked);
    Reply record(const Asked& asked);
    Reply keep_draft(const Asked& asked);
    Reply take_draft_back(const Asked& asked);

    HttpAnswer of_no_route(const HttpRequest& request) const;
    HttpAnswer file_of_page(const HttpRequest& request) const;
    /// The draft in a request, which this visitor may have judged, or why not.
    static tl::expected<std::string, HttpAnswer> draft_in(const Asked& asked);
    Reply with_recordings(const KnownDaemon& daemon, Instant now,
                          std::function<Reply(const RecordingsPlace&)> go_on);
    Reply begin_plot(const RecordingsPlace& place, const std::string& name,
                     const std::string& query);
    bool others_learn(const Visitor& visitor) const;
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
    static std::optional<HttpAnswer> why_no_draft(const Asked& asked, const std::string& text);
    Reply run_draft(const KnownDaemon& daemon, Draft draft, std::int64_t seconds, Instant now);
    Reply keep_own_draft(const Asked& asked, Draft& draft);

    bool begin_stream(SocketClient& client, const Asked& asked);
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
    PairingPauses pairing_pauses_;
    RateLimit wrong_codes_limit_{3, std::chrono::minutes(1)};
    std::vector<std::string> names_;
    std::list<std::weak_ptr<Stream>> streams_;
    std::map<std::string, std::unique_ptr<DaemonWatch>> watches_;
    std::list<std::shared_ptr<Pending>> pending_;
    std::map<std::string, Draft> drafts_;
    std::shared_ptr<Learning> learning_;
    std::shared_ptr<PlotJob> plotting_;  ///< null while no recording is read
};

}  // namespace tribus::web

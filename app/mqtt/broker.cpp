#include "app/mqtt/broker.h"

#include <mosquitto.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/mqtt/connect_pauses.h"
#include "app/mqtt/discovery.h"
#include "pipelines/realtime/clock.h"

namespace tribus::mqtt {
namespace {

constexpr int kKeepAliveSeconds = 10;
constexpr int kLoopMilliseconds = 50;
constexpr int kMostAtOnce = 64;
constexpr std::chrono::seconds kStopPatience(2);
constexpr Duration kFarewell = std::chrono::seconds(1);

/// Explains an error of TLS that the library named, to the person who must act.
std::string tls_problem(const BrokerOptions& options, std::string_view said) {
    const auto has = [said](std::string_view part) {
        return said.find(part) != std::string_view::npos;
    };
    if (has("certificate verify failed")) {
        return fmt::format(
            "its certificate is refused: it is not signed by {}, is out of date, or is for another "
            "name than {}",
            options.authority.empty() ? "an authority of this system (--ca names another)"
                                      : "the authority in " + options.authority,
            options.host);
    }
    if (has("certificate required") || has("unknown ca") || has("bad certificate") ||
        has("certificate unknown") || has("handshake failure")) {
        return options.certificate.empty()
                   ? "it wants a certificate of this program: give --certificate and --key"
                   : fmt::format("it refuses the certificate in {}", options.certificate);
    }
    if (has("wrong version number")) {
        return "it does not speak TLS at this port; brokers usually do at 8883";
    }
    return said.empty() ? "TLS failed" : fmt::format("TLS failed: {}", said);
}

/// Boards start at the same moment too, but have names of their own.
std::uint32_t seed_of(const std::string& client_id) {
    const auto now = static_cast<std::uint64_t>(monotonic_now().time_since_epoch().count());
    return static_cast<std::uint32_t>(std::hash<std::string>{}(client_id) + now);
}

std::string error_text(int result) {
    if (result == MOSQ_ERR_NOMEM) {
        return "it announces a message for which this program has no memory";
    }
    return result == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(result);
}

}  // namespace

/// One connection, from the attempt to its end. The library calls its functions inside `loop`.
class Broker::Session {
  public:
    Session(const BrokerOptions& options, Outbox& outbox) : options_(options), outbox_(outbox) {
        client_ = mosquitto_new(options.client_id.c_str(), true, this);
    }
    ~Session() {
        if (client_ != nullptr) {
            mosquitto_destroy(client_);
        }
        if (connected_) {
            outbox_.disconnected();
        }
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// The error says which option is wrong.
    tl::expected<void, std::string> set_up() {
        if (client_ == nullptr) {
            return tl::unexpected(std::string("no memory for a connection"));
        }
        mosquitto_connect_callback_set(client_, [](mosquitto*, void* self, int code) {
            static_cast<Session*>(self)->answered(code);
        });
        mosquitto_publish_callback_set(client_, [](mosquitto*, void* self, int message) {
            static_cast<Session*>(self)->acknowledged(message);
        });
        mosquitto_message_callback_set(
            client_, [](mosquitto*, void* self, const mosquitto_message* message) {
                static_cast<Session*>(self)->received(*message);
            });
        mosquitto_log_callback_set(client_,
                                   [](mosquitto*, void* self, int level, const char* text) {
                                       static_cast<Session*>(self)->said(level, text);
                                   });
        mosquitto_will_set(client_, options_.availability_topic.c_str(),
                           static_cast<int>(kOffline.size()), kOffline.data(), 1, true);
        if (!options_.user.empty()) {
            mosquitto_username_pw_set(client_, options_.user.c_str(), options_.password.c_str());
        }
        return options_.encrypted ? set_up_tls() : tl::expected<void, std::string>{};
    }
    /// May block as long as names and connections take. Returns an empty text, or why not.
    std::string connect() {
        const int result =
            mosquitto_connect(client_, options_.host.c_str(), options_.port, kKeepAliveSeconds);
        return result == MOSQ_ERR_SUCCESS ? std::string() : reason(result);
    }
    /// Sends and receives for a moment. Returns why the connection has ended, if it has.
    std::optional<std::string> loop() {
        if (connected_) {
            send_some();
        }
        const int result = mosquitto_loop(client_, kLoopMilliseconds, 1);
        if (!refusal_.empty()) {
            return refusal_;
        }
        return result == MOSQ_ERR_SUCCESS ? std::nullopt : std::optional(reason(result));
    }
    bool connected() const { return connected_; }

    void say_farewell() {
        if (!connected_) {
            return;
        }
        int message = 0;
        mosquitto_publish(client_, &message, options_.availability_topic.c_str(),
                          static_cast<int>(kOffline.size()), kOffline.data(), 1, true);
        farewell_ = message;
        const Instant end = later(monotonic_now(), kFarewell);
        while (farewell_ && monotonic_now() < end &&
               mosquitto_loop(client_, kLoopMilliseconds, 1) == MOSQ_ERR_SUCCESS) {
        }
        mosquitto_disconnect(client_);
    }

  private:
    tl::expected<void, std::string> set_up_tls() {
        const auto or_null = [](const std::string& text) {
            return text.empty() ? nullptr : text.c_str();
        };
        const char* folder = options_.authority.empty() ? "/etc/ssl/certs" : nullptr;
        const int result =
            mosquitto_tls_set(client_, or_null(options_.authority), folder,
                              or_null(options_.certificate), or_null(options_.key), nullptr);
        if (result != MOSQ_ERR_SUCCESS) {
            return tl::unexpected(
                fmt::format("the files of --ca, --certificate and --key cannot be used: {}",
                            error_text(result)));
        }
        return {};
    }

    void answered(int code) {
        if (code != 0) {
            const bool no_right = code == 4 || code == 5;
            refusal_ = fmt::format("it refuses: {}{}", mosquitto_connack_string(code),
                                   no_right ? "; see --user and --password-file" : "");
            return;
        }
        connected_ = true;
        outbox_.connected();
        if (!options_.birth_topic.empty()) {
            mosquitto_subscribe(client_, nullptr, options_.birth_topic.c_str(), 1);
        }
    }

    void acknowledged(int message) {
        if (farewell_ == message) {
            farewell_.reset();
        }
        if (const auto event = events_.find(message); event != events_.end()) {
            outbox_.acknowledged(event->second);
            events_.erase(event);
        }
    }

    void received(const mosquitto_message& message) {
        const std::string_view payload(static_cast<const char*>(message.payload),
                                       static_cast<std::size_t>(message.payloadlen));
        if (message.topic == options_.birth_topic && payload == kOnline) {
            outbox_.retain_again(options_.discovery_topics);
        }
    }

    void said(int level, const char* text) {
        if (level == MOSQ_LOG_ERR || level == MOSQ_LOG_WARNING) {
            said_ = text;
        }
    }

    std::string reason(int result) {
        const std::string said = std::exchange(said_, {});
        const bool of_tls = result == MOSQ_ERR_TLS || said.find("OpenSSL") != std::string::npos;
        return of_tls && options_.encrypted ? tls_problem(options_, said) : error_text(result);
    }

    /// While the kernel takes what is sent; the broker may be slow, and memory is not for it.
    void send_some() {
        for (int i = 0; i < kMostAtOnce && !mosquitto_want_write(client_); ++i) {
            const auto message = outbox_.next(monotonic_now());
            if (!message) {
                return;
            }
            int number = 0;
            mosquitto_publish(client_, &number, message->topic.c_str(),
                              static_cast<int>(message->payload.size()), message->payload.data(),
                              message->quality, message->retained);
            if (message->event != 0) {
                events_[number] = message->event;
            }
        }
    }

    const BrokerOptions& options_;
    Outbox& outbox_;
    mosquitto* client_ = nullptr;
    bool connected_ = false;
    std::string refusal_;
    std::string said_;
    std::map<int, std::uint64_t> events_;  ///< by the library's number of the message
    std::optional<int> farewell_;
};

tl::expected<std::unique_ptr<Broker>, std::string> Broker::start(BrokerOptions options,
                                                                 Outbox& outbox) {
    mosquitto_lib_init();
    if (auto tried = Session(options, outbox).set_up(); !tried) {
        return tl::unexpected(tried.error());
    }
    UniqueFd has_reports(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (!has_reports.valid()) {
        return tl::unexpected(std::string(std::strerror(errno)));
    }
    std::unique_ptr<Broker> broker(new Broker(std::move(options), outbox, std::move(has_reports)));
    try {
        broker->thread_ = std::thread([&self = *broker] { self.run(); });
    } catch (const std::system_error& error) {
        return tl::unexpected(std::string("cannot start a thread: ") + error.what());
    }
    return broker;
}

Broker::Broker(BrokerOptions options, Outbox& outbox, UniqueFd has_reports)
    : options_(std::move(options)), outbox_(outbox), has_reports_(std::move(has_reports)) {}

Broker::~Broker() {
    if (thread_.joinable()) {
        stop();
        thread_.join();
    }
    mosquitto_lib_cleanup();
}

bool Broker::stop() {
    std::unique_lock lock(mutex_);
    stops_ = true;
    changed_.notify_all();
    return changed_.wait_for(lock, kStopPatience, [this] { return ended_; });
}

std::vector<std::string> Broker::take_reports() {
    const std::lock_guard lock(mutex_);
    std::uint64_t count = 0;
    [[maybe_unused]] const auto cleared = ::read(has_reports_.get(), &count, sizeof count);
    return std::exchange(reports_, {});
}

/// The same reason again is not told again.
void Broker::report(std::string text) {
    const std::lock_guard lock(mutex_);
    if (text == last_report_) {
        return;
    }
    last_report_ = text;
    reports_.push_back(std::move(text));
    constexpr std::uint64_t kOnce = 1;
    [[maybe_unused]] const auto told = ::write(has_reports_.get(), &kOnce, sizeof kOnce);
}

void Broker::run() {
    const std::string place = fmt::format("broker {}:{}", options_.host, options_.port);
    ConnectPauses pauses(seed_of(options_.client_id));
    const auto stops = [this] {
        const std::lock_guard lock(mutex_);
        return stops_;
    };
    while (!stops()) {
        Session session(options_, outbox_);
        std::optional<std::string> end;
        if (const auto set_up = session.set_up(); !set_up) {
            end = set_up.error();
        } else if (std::string why = session.connect(); !why.empty()) {
            end = std::move(why);
        }
        while (!end && !stops()) {
            const bool before = session.connected();
            end = session.loop();
            if (!before && session.connected()) {
                report(place + ": connected");
                pauses.connected();
            }
        }
        if (!end) {
            session.say_farewell();
            break;
        }
        report(fmt::format("{}: {}; trying again", place, *end));
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, pauses.next(), [this] { return stops_; });
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
}

}  // namespace tribus::mqtt

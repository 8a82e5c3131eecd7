#include "app/mqtt/mqtt_command.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/cli/process_limit.h"
#include "app/journal/log.h"
#include "app/mqtt/board_watch.h"
#include "app/mqtt/broker.h"
#include "app/mqtt/broker_place.h"
#include "app/mqtt/outbox.h"
#include "app/mqtt/report.h"
#include "config/language/read_file.h"
#include "core/quotes.h"
#include "pipelines/realtime/clock.h"

namespace tribus::mqtt {
namespace {

constexpr int kPlainPort = 1883;
constexpr int kTlsPort = 8883;
constexpr std::size_t kMostPasswordBytes = 256;
/// As MemoryMax= of the service. The library takes whatever length a broker announces for a
/// message; the build of the sanitizers needs more for itself.
[[maybe_unused]] constexpr rlim_t kMostMemory = rlim_t{48} << 20U;
/// As long as a host name of Linux may be.
constexpr std::size_t kMostBoardBytes = HOST_NAME_MAX;
constexpr Duration kLookPeriod = std::chrono::milliseconds(250);
constexpr Duration kSearchPeriod = std::chrono::seconds(2);
constexpr std::pair<double, double> kEventRange{1, 100'000};

struct MqttOptions {
    std::string broker = "127.0.0.1";
    std::string board;
    std::string prefix = "tribus";
    std::string discovery = "homeassistant";
    std::string authority;
    std::string certificate;
    std::string key;
    std::string user;
    std::string password_file;
    bool tls = false;
    bool unencrypted = false;
    int events = 1000;
    std::string version;

    bool wants_tls() const {
        return tls || !authority.empty() || !certificate.empty() || !key.empty();
    }
};

std::string name_of_this_board() {
    std::array<char, HOST_NAME_MAX + 1> name{};
    const bool known = ::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0';
    return known ? std::string(name.data()) : "board";
}

/// The first line of the file.
tl::expected<std::string, std::string> password_in(const std::string& path) {
    auto text = read_file(path, kMostPasswordBytes, FileKinds::secret);
    if (!text) {
        return tl::unexpected(fmt::format("--password-file {}: {}", path, text.error()));
    }
    return text->substr(0, text->find('\n'));
}

/// Checks what the options say together.
tl::expected<BrokerOptions, std::string> broker_options(const MqttOptions& options) {
    const auto place = parse_broker_place(options.broker);
    if (!place) {
        return tl::unexpected(fmt::format(
            "--broker {}: allowed: a name or an address, and a port from 1 to 65535, such as "
            "broker.local:8883",
            in_quotes(options.broker)));
    }
    if (options.board.size() > kMostBoardBytes) {
        return tl::unexpected(
            fmt::format("--board: allowed: a name of at most {} bytes", kMostBoardBytes));
    }
    for (const auto& [option, value] :
         {std::pair("--prefix", &options.prefix), std::pair("--discovery", &options.discovery)}) {
        if (!may_begin_topics(*value)) {
            return tl::unexpected(fmt::format(
                "{} {}: allowed: 1 to 64 letters without accents, digits and signs, in levels "
                "such as boats or home/boats; no blanks, + or #, no $ at the beginning, no empty "
                "level",
                option, in_quotes(*value)));
        }
    }
    if (options.certificate.empty() != options.key.empty()) {
        return tl::unexpected(
            std::string("--certificate and --key belong together: give both, or none"));
    }
    if (!options.wants_tls() && !options.unencrypted && !place->is_loopback()) {
        return tl::unexpected(fmt::format(
            "--broker {}: the network can read and change what is told, and the password; add "
            "--tls or --ca FILE, or --unencrypted if that may be",
            in_quotes(options.broker)));
    }
    BrokerOptions broker{.host = place->host,
                         .port = place->port.value_or(options.wants_tls() ? kTlsPort : kPlainPort),
                         .user = options.user,
                         .encrypted = options.wants_tls(),
                         .authority = options.authority,
                         .certificate = options.certificate,
                         .key = options.key};
    if (!options.password_file.empty()) {
        auto password = password_in(options.password_file);
        if (!password) {
            return tl::unexpected(password.error());
        }
        broker.password = std::move(*password);
    }
    return broker;
}

void log_reports(Broker& broker) {
    for (const std::string& text : broker.take_reports()) {
        if (text.ends_with(": connected")) {
            log_info("{}", text);
        } else {
            log_warning("{}", text);
        }
    }
}

std::chrono::microseconds wall_time() {
    return std::chrono::duration_cast<std::chrono::microseconds>(wall_time_now());
}

int watch(BoardWatch& board, Broker& broker, MainWait& wait) {
    Instant search{};
    for (;;) {
        const Instant now = monotonic_now();
        if (now >= search) {
            board.look_for_daemons(find_telling_sockets(SocketDirectories::of_this_process()), now);
            search = later(now, kSearchPeriod);
        }
        board.look(now, wall_time());
        log_reports(broker);
        std::vector<int> watched = board.descriptors();
        watched.push_back(broker.descriptor());
        if (wait.until(later(monotonic_now(), kLookPeriod), watched)) {
            return kExitFine;
        }
    }
}

int run(const MqttOptions& options) {
    auto broker_wanted = broker_options(options);
    if (!broker_wanted) {
        return complain(broker_wanted.error(), kExitWrongUse);
    }
    auto wait = MainWait::for_signals({SIGTERM, SIGINT});
    if (!wait) {
        log_error("{}", wait.error());
        return kExitFailed;
    }
    const std::string board_name = options.board.empty() ? name_of_this_board() : options.board;
    Outbox outbox(fmt::format("{}-{}", wall_time().count(), ::getpid()),
                  {.events = static_cast<std::size_t>(options.events)});
    BoardWatch board({.board = board_name,
                      .prefix = options.prefix,
                      .discovery = options.discovery == "off" ? "" : options.discovery,
                      .version = options.version},
                     outbox);
    broker_wanted->client_id = "tribus-" + topic_level(board_name);
    broker_wanted->availability_topic =
        topics_of(options.prefix, board_name, "").board_availability;
    if (options.discovery != "off") {
        broker_wanted->birth_topic = options.discovery + "/status";
        broker_wanted->discovery_topics = options.discovery + "/device/";
    }
#ifndef TRIBUS_SANITIZED
    if (!limit_process(RLIMIT_DATA, kMostMemory)) {
        log_error("cannot limit its own memory: {}", std::strerror(errno));
        return kExitFailed;
    }
#endif
    auto broker = Broker::start(std::move(*broker_wanted), outbox);
    if (!broker) {
        log_error("{}", broker.error());
        return kExitFailed;
    }
    const int status = watch(board, **broker, *wait);
    if (!(*broker)->stop()) {
        // The thread waits for the network; nothing is lost that a signal would not lose.
        std::_Exit(status);
    }
    return status;
}

std::vector<CommandOption> options_into(MqttOptions& options) {
    return {{.name = "--broker",
             .value = &options.broker,
             .help = "The broker; port 1883, with TLS 8883",
             .shows_value = true,
             .value_name = "HOST[:PORT]"},
            {.name = "--board",
             .value = &options.board,
             .help = "Name of this board in topics; default: its host name",
             .value_name = "NAME"},
            {.name = "--prefix",
             .value = &options.prefix,
             .help = "First levels of the topics",
             .shows_value = true,
             .value_name = "LEVEL"},
            {.name = "--discovery",
             .value = &options.discovery,
             .help = "First levels of Home Assistant's topics; off: no discovery",
             .shows_value = true,
             .value_name = "LEVEL"},
            {.name = "--tls",
             .value = &options.tls,
             .help = "Encrypt, and accept brokers with a certificate of this system's authorities"},
            {.name = "--ca",
             .value = &options.authority,
             .help = "The authority of the broker's certificate; encrypts",
             .value_name = "FILE"},
            {.name = "--certificate",
             .value = &options.certificate,
             .help = "The certificate of this program, for brokers that want one",
             .value_name = "FILE"},
            {.name = "--key",
             .value = &options.key,
             .help = "The key of that certificate",
             .value_name = "FILE"},
            {.name = "--user",
             .value = &options.user,
             .help = "Name at the broker",
             .value_name = "NAME"},
            {.name = "--password-file",
             .value = &options.password_file,
             .help = "The password in its first line; others may not read the file",
             .value_name = "FILE",
             .needs = {"--user"}},
            {.name = "--unencrypted",
             .value = &options.unencrypted,
             .help = "Allow a broker on another machine without encryption"},
            {.name = "--events",
             .value = &options.events,
             .help = "Most events that are kept while the broker is away",
             .shows_value = true,
             .range = kEventRange,
             .value_name = "NUMBER"}};
}

}  // namespace

Command mqtt_command(std::string version) {
    auto options = std::make_shared<MqttOptions>();
    options->version = std::move(version);
    return {
        .name = "run",
        .help = "Tell an MQTT broker of all daemons of this board: status, events, values",
        .notes =
            "Nothing can be steered over MQTT: what the broker sends is not read, but for the "
            "start of Home Assistant.",
        .options = options_into(*options),
        .examples = {{"tribus-mqtt run --broker localhost", "a broker on this board"},
                     {"tribus-mqtt run --broker home.local --tls --user boat --password-file pass",
                      "a broker in the network, encrypted, with a password"}},
        .exits = {{kExitFine, "ended by a signal"},
                  {kExitFailed, "it failed, or the broker does not accept it"},
                  {kExitWrongUse, "wrong use"}},
        .run =
            [options] {
                log_to_journal_or_terminal();
                return run(*options);
            },
    };
}

}  // namespace tribus::mqtt

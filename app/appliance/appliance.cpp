#include "app/appliance/appliance.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "config/language/mistakes.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Without it nothing could be proved, so the program ends.
RandomSeed random_seed() {
    RandomSeed seed{};
    if (::getentropy(seed.data(), seed.size()) != 0) {
        std::fputs("the kernel gives no random numbers (getentropy); a key needs them\n", stderr);
        std::abort();
    }
    return seed;
}

/// `Appliance::epochs_` keep them.
NumberReservation* numbers(const std::string& epoch) {
    return EpochFile::of(epoch).get();
}

}  // namespace

std::vector<Appliance::Epoch> Appliance::epochs_of(const Configuration& configuration) {
    std::vector<Epoch> epochs;
    const auto add = [&](const auto& parts, SettingScope way, std::string_view table) {
        for (const auto& part : parts) {
            if (const auto link = link_with_key(part); link && link->epoch) {
                const Location where = part.port.where;
                epochs.push_back({EpochFile::of(*link->epoch), way,
                                  fmt::format("{}:{}:{}: [{}.{}]", configuration.file, where.line,
                                              where.column, table, part.name)});
            }
        }
    };
    add(configuration.inputs, SettingScope::input, "input");
    add(configuration.outputs, SettingScope::output, "output");
    return epochs;
}

Appliance::Appliance(Configuration configuration)
    : configuration_(std::move(configuration)),
      epochs_(epochs_of(configuration_)),
      plans_(plan_ports(configuration_)),
      missing_(plans_.size(), false),
      open_problems_(plans_.size()),
      engine_(build_engine(configuration_, machine_id(),
                           {.clock = &wall_clock(), .random = random_seed, .numbers = numbers})) {
    follow_wall_clock();
    values_ = build_value_engine(configuration_, *engine_, &wall_clock());
}

std::unique_ptr<Appliance> Appliance::build(Configuration configuration) {
    return std::unique_ptr<Appliance>(new Appliance(std::move(configuration)));
}

bool Appliance::restart_wanted() const {
    for (std::size_t node = 0; node < engine_->node_count(); ++node) {
        if (node_report(node).restart_wanted) {
            return true;
        }
    }
    return false;
}

std::size_t Appliance::reject_cause_count(std::size_t input) const {
    return std::min(engine_->inputs()[input].decoder().rejected().size(), kMostRejectCauses);
}

std::string_view Appliance::reject_cause(std::size_t input, std::size_t cause) const {
    return engine_->inputs()[input].decoder().rejected()[cause].name;
}

void Appliance::look_at_machine(Instant now, bool watches) {
    constexpr Duration kPeriod = std::chrono::seconds(1);
    follow_wall_clock();
    if (!(values_ || watches) || now < next_machine_look_) {
        return;
    }
    next_machine_look_ = later(now, kPeriod);
    machine_.set(machine_watch_.look(), now);
}

void Appliance::open_files() {
    if (std::exchange(files_opened_, true)) {
        return;
    }
    for (const Epoch& epoch : epochs_) {
        if (const auto opened = epoch.file->open(epoch.way); !opened) {
            file_errors_.push_back(fmt::format("{} epoch: {}", epoch.place, opened.error()));
        }
    }
}

std::vector<std::shared_ptr<EpochFile>> Appliance::epoch_files() const {
    std::vector<std::shared_ptr<EpochFile>> files;
    for (const Epoch& epoch : epochs_) {
        files.push_back(epoch.file);
    }
    return files;
}

void Appliance::look_at_epochs() {
    for (const Epoch& epoch : epochs_) {
        epoch.file->look();
    }
}

std::vector<std::string> Appliance::open_devices(MissingDevices missing) {
    open_files();
    std::vector<std::string> errors = file_errors_;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    // Lines come first: one may select an inverter, which must be set before its port opens.
    auto lines = open_lines(missing, errors);
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        links.push_back(open_or_wait(port, missing, errors));
        wiring.push_back(plans_[port].wiring);
    }
    if (errors.empty()) {
        errors = make_threads(std::move(wiring), std::move(links), std::move(lines));
    }
    return errors;
}

std::unique_ptr<Link> Appliance::open_or_wait(std::size_t port, MissingDevices missing,
                                              std::vector<std::string>& errors) {
    auto link = open_port(configuration_, stations(), plans_[port]);
    missing_[port] = !link;
    if (link) {
        return std::move(*link);
    }
    if (missing == MissingDevices::wait_for_absent &&
        plans_[port].config.medium->is_missing(plans_[port].config.device)) {
        waits_for_.push_back(link.error());
    } else if (missing != MissingDevices::wait_for) {
        errors.push_back(link.error());
    }
    return nullptr;
}

std::vector<std::unique_ptr<HeldLine>> Appliance::open_lines(MissingDevices missing,
                                                             std::vector<std::string>& errors) {
    std::vector<std::unique_ptr<HeldLine>> lines;
    for (const LineConfig& config : configuration_.lines) {
        auto line = open_line(configuration_, config);
        if (!line && missing != MissingDevices::wait_for) {
            errors.push_back(line.error());
        }
        missing_lines_.push_back(!line);
        lines.push_back(line ? std::move(*line) : nullptr);
    }
    return lines;
}

std::vector<std::string> Appliance::make_threads(std::vector<PortWiring> wiring,
                                                 std::vector<std::unique_ptr<Link>> links,
                                                 std::vector<std::unique_ptr<HeldLine>> lines) {
    const RuntimeConfig& runtime = configuration_.runtime;
    if (!lines.empty()) {
        line_exchange_ = std::make_unique<LineExchange>(engine_->outputs().size());
        if (auto prepared = line_exchange_->prepare(); !prepared) {
            return {prepared.error()};
        }
        // One priority below the data thread, which it must never delay.
        const bool first = runtime.realtime != Realtime::off && runtime.priority > 1;
        gpio_thread_ = std::make_unique<GpioThread>(
            *line_exchange_, line_tasks(configuration_), std::move(lines),
            GpioThreadSettings{first ? std::optional(runtime.priority - 1) : std::nullopt});
        line_exchange_->set_states(engine_->shown_on_lines());
    }
    loop_ = std::make_unique<Loop>(*engine_, std::move(wiring), std::move(links),
                                   loop_settings(line_exchange_.get()));
    if (auto prepared = loop_->prepare(); !prepared) {
        return {prepared.error()};
    }
    return {};
}

LoopSettings Appliance::loop_settings(LineExchange* lines) {
    return {.spin = configuration_.runtime.spin,
            .lines = lines,
            .values = values_.get(),
            .machine = &machine_};
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    Configuration configuration, MissingDevices missing) {
    return start(build(std::move(configuration)), missing);
}

tl::expected<std::unique_ptr<Appliance>, std::string> Appliance::start_text(
    const std::string& text, const std::string& name) {
    auto configuration = load_configuration(text, name);
    if (!configuration) {
        return tl::unexpected(format_mistake(configuration.error().front()));
    }
    return start(std::move(*configuration)).map_error([](const auto& errors) {
        return errors.front();
    });
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    std::unique_ptr<Appliance> built, MissingDevices missing) {
    std::unique_ptr<FlightRecorder> none;
    return start(std::move(built), missing, none, DiskPatience::waits);
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    std::unique_ptr<Appliance> built, MissingDevices missing,
    std::unique_ptr<FlightRecorder>& recorder) {
    return start(std::move(built), missing, recorder, DiskPatience::does_not_wait);
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    std::unique_ptr<Appliance> appliance, MissingDevices missing,
    std::unique_ptr<FlightRecorder>& recorder, DiskPatience patience) {
    handle_sigcont();
    const auto made = appliance->make_recorder(recorder, patience);
    std::vector<std::string> errors = appliance->open_devices(missing);
    if (!made) {
        errors.push_back(made.error());
    }
    if (!errors.empty()) {
        return tl::unexpected(std::move(errors));
    }
    appliance->record_ports(recorder.get());
    // Must precede `prepare`, where the data thread locks all memory, including the stacks.
    if (appliance->gpio_thread_) {
        if (auto started = appliance->gpio_thread_->start(); !started) {
            return tl::unexpected(std::vector{started.error()});
        }
    }
    const RuntimeConfig& runtime = appliance->configuration_.runtime;
    appliance->thread_ = std::make_unique<DataThread>(
        *appliance->loop_, SchedulingSettings{.priority = runtime.priority,
                                              .cpu = runtime.cpu,
                                              .realtime = runtime.realtime != Realtime::off});
    auto missing_realtime = appliance->thread_->prepare();
    if (!missing_realtime) {
        return tl::unexpected(std::vector{missing_realtime.error()});
    }
    if (runtime.realtime == Realtime::require && !missing_realtime->empty()) {
        return tl::unexpected(std::move(*missing_realtime));
    }
    appliance->missing_realtime_ = std::move(*missing_realtime);
    if (appliance->configuration_.recorder) {
        appliance->recorder_ = std::move(recorder);
    }
    appliance->thread_->run();
    return appliance;
}

std::optional<bool> Appliance::line_active(std::size_t line) const {
    const LineRole role = configuration_.lines[line].task.role;
    if (!line_present(line) || role == LineRole::fresh) {
        return std::nullopt;
    }
    if (is_input_role(role)) {
        return line_exchange_->levels(monotonic_now()).of(line);
    }
    const LineStates states = line_exchange_->states();
    return (states.blinking & line_bit(line)) != 0
               ? std::nullopt
               : std::optional((states.on & line_bit(line)) != 0);
}

bool Appliance::uses_fd(const PortWiring& wiring) const {
    return std::ranges::any_of(wiring.stations, [stations = stations()](Station station) {
        return stations.uses_fd(station);
    });
}

void Appliance::end() {
    loop_->request_end();
    thread_->join();
    if (gpio_thread_) {
        gpio_thread_->end();
    }
}

}  // namespace tribus

#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

#include "app/mqtt/outbox.h"
#include "transports/links/unique_fd.h"

namespace tribus::mqtt {

struct BrokerOptions {
    std::string host = "127.0.0.1";
    int port = 0;
    std::string client_id{};
    std::string user{};
    std::string password{};
    bool encrypted = false;
    std::string authority{};    ///< file of certificates; empty: those of the system
    std::string certificate{};  ///< file of this program's own; empty: none
    std::string key{};          ///< file
    /// Topic that says "offline" when this program is gone.
    std::string availability_topic{};
    /// Topic on which Home Assistant says that it has started; empty: none.
    std::string birth_topic{};
    /// Retained messages below this topic are sent again then.
    std::string discovery_topics{};
};

/// The connection to a broker (MQTT 3.1.1), on a thread of its own that takes what it sends from
/// the outbox and connects again by itself. The functions belong to the main thread.
class Broker {
  public:
    /// The error says which option is wrong.
    static tl::expected<std::unique_ptr<Broker>, std::string> start(BrokerOptions options,
                                                                    Outbox& outbox);
    Broker(const Broker&) = delete;
    Broker& operator=(const Broker&) = delete;
    ~Broker();

    /// Says "offline" and disconnects. Returns false if the thread has not ended within 2 s: it
    /// waits for the network then.
    bool stop();

    /// Readable when there are reports.
    int descriptor() const { return has_reports_.get(); }
    /// Sentences for the log: connected, gone, refused.
    std::vector<std::string> take_reports();

  private:
    class Session;

    Broker(BrokerOptions options, Outbox& outbox, UniqueFd has_reports);
    void run();
    void report(std::string text);

    BrokerOptions options_;
    Outbox& outbox_;
    UniqueFd has_reports_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::string> reports_;
    std::string last_report_;
    bool stops_ = false;
    bool ended_ = false;
    std::thread thread_;
};

}  // namespace tribus::mqtt

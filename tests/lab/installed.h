#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/program.h"
#include "tests/loopback/wire.h"

/// The package in a fresh Debian with systemd. i.Bus in at a 16550, SBUS out at an FTDI adapter.
namespace tribus::test {

inline const std::string kPackage = "/host" TRIBUS_PACKAGE;
inline const std::string kUnit = "tribus@servos.service";
inline const std::filesystem::path kConfigurations = "/etc/tribus";
inline const std::filesystem::path kDropIns = "/run/systemd/system";

/// Like `eventually`, but for conditions that need a process, which takes long in a guest.
template <class Done>
bool in_time(Done done) {
    const auto end = Clock::now() + 4 * kPatience;
    while (!done()) {
        if (Clock::now() > end) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    return true;
}

inline void install() {
    shell("apt-get -q -y install " + kPackage);
}

inline void write_file(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

inline std::string property(const std::string& name, const std::string& unit = kUnit) {
    std::string value = shell("systemctl show -P " + name + " " + unit);
    while (!value.empty() && value.back() == '\n') {
        value.pop_back();
    }
    return value;
}

inline bool becomes(const std::string& name, const std::string& value,
                    const std::string& unit = kUnit) {
    return in_time([&] { return property(name, unit) == value; });
}

/// Returns the time in the format of journalctl.
inline std::string now_for_journal() {
    const std::string seconds = shell("date +%s.%6N");
    return "@" + seconds.substr(0, seconds.find('\n'));
}

/// The installed package, with a receiver and servos at the far ends of the guest's wires.
class InstalledPackage : public testing::Test {
  protected:
    static void SetUpTestSuite() { install(); }

    InstalledPackage() : receiver_(uart_16550(2), kIbus), servos_(ftdi_adapter(2), kSbus) {
        configure("");
    }
    ~InstalledPackage() override {
        run_shell("systemctl stop 'tribus@*'; systemctl reset-failed 'tribus@*'");
        if (std::filesystem::remove_all(kDropIns / (kUnit + ".d")) > 0) {
            run_shell("systemctl daemon-reload");
        }
    }

    static void configure(const std::string& channels) {
        write_file(kConfigurations / "servos.toml",
                   "[input.receiver]\nprotocol = \"ibus\"\ntimeout = \"5s\"\ndevice = \"" +
                       uart_16550(1) + "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                       ftdi_adapter(1) +
                       "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n" + channels);
    }
    /// Returns the journal since the start of this test.
    std::string journal(const std::string& options = "", const std::string& unit = kUnit) const {
        return shell("journalctl --sync; journalctl -q -o cat --since=" + begin_ + " -u " + unit +
                     " " + options);
    }
    static void drop_in(const std::string& unit, const std::string& text) {
        write_file(kDropIns / (unit + ".d") / "test.conf", text);
        shell("systemctl daemon-reload");
    }

    /// Sends an i.Bus frame every few milliseconds until an SBUS frame in control has `out_us` on
    /// channel 1.
    bool carries(int in_us, int out_us) {
        const Bytes ibus = ibus_bytes(sticks_with_first(in_us));
        const Bytes sbus = sbus_bytes(sbus_sight_of(sticks_with_first(out_us)));
        Bytes seen;
        auto latest = Clock::time_point{};
        servos_.receive();
        return eventually([&] {
            if (Clock::now() - latest > std::chrono::milliseconds(7)) {
                latest = Clock::now();
                receiver_.send(ibus);
            }
            const Bytes more = servos_.receive();
            seen.insert(seen.end(), more.begin(), more.end());
            return std::search(seen.begin(), seen.end(), sbus.begin(), sbus.end()) != seen.end();
        });
    }

    Uart receiver_;
    Uart servos_;

  private:
    std::string begin_ = now_for_journal();
};

class InstalledService : public InstalledPackage {
  protected:
    InstalledService() { shell("systemctl start " + kUnit); }

    /// Restarts the service with the library that makes a thread hang on a signal.
    static void restart_with_hang_preload() {
        std::filesystem::copy_file("/host" TRIBUS_HANG_PRELOAD, "/usr/local/lib/hang.so",
                                   std::filesystem::copy_options::overwrite_existing);
        drop_in(kUnit, "[Service]\nEnvironment=LD_PRELOAD=/usr/local/lib/hang.so\n");
        shell("systemctl restart " + kUnit);
    }
};

/// A unit of the package whose program is replaced by one that tries what is forbidden.
class TriedSandbox {
  public:
    /// `attempts`: lines `try NAME 'COMMAND'`. Their output goes to `output`, which the sandbox
    /// lets the unit write.
    TriedSandbox(const std::string& unit, const std::string& settings, const std::string& output,
                 const std::string& attempts) {
        write_file("/home/somebody/secret", "treasure\n");
        shell("chmod -R a+rX /home; mkdir -p /srv/open; chmod 777 /srv/open; chmod 666 /dev/vda");
        write_file("/usr/local/lib/probe.sh",
                   "exec >" + output +
                       " 2>&1\n"
                       "try() { echo \"$1: $(eval \"$2\" 2>&1 | tr '\\n' ' ')\"; }\n"
                       "try rights \"grep -hE '^(CapPrm|CapBnd|NoNewPrivs|Seccomp):' "
                       "/proc/self/status\"\n"
                       "try home 'cat /home/somebody/secret'\n"
                       "try system 'touch /srv/open/a'\n"
                       "try disk 'head -c 1 /dev/vda'\n"
                       "try internet 'exec 3<>/dev/tcp/127.0.0.1/22'\n"
                       "try namespace 'unshare --user true'\n" +
                       attempts);
        const std::filesystem::path drop_in = kDropIns / (unit + ".d");
        write_file(drop_in / "test.conf",
                   "[Service]\nType=oneshot\n" + settings +
                       "ExecStart=\nExecStart=/bin/bash /usr/local/lib/probe.sh\n");
        shell("systemctl daemon-reload; systemctl start " + unit);
        std::ifstream file(output);
        for (std::string line; std::getline(file, line);) {
            const std::size_t colon = line.find(": ");
            tried_[line.substr(0, colon)] = line.substr(colon + 2);
        }
        shell("rm -r " + drop_in.string() + " " + output + "; systemctl daemon-reload");
    }

    /// What became of an attempt.
    const std::string& of(const std::string& attempt) { return tried_[attempt]; }
    bool says(const std::string& attempt, const std::string& text) {
        return of(attempt).find(text) != std::string::npos;
    }

  private:
    std::map<std::string, std::string> tried_;
};

inline constexpr const char* kNoRights =
    "CapPrm:\t0000000000000000 CapBnd:\t0000000000000000 NoNewPrivs:\t1 Seccomp:\t2 ";

}  // namespace tribus::test

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

/// The package in a fresh Debian with systemd: installed, running on real drivers, supervised,
/// confined and removed. i.Bus in at a 16550, SBUS out at an FTDI adapter.
namespace tribus::test::systemd_service_test {
namespace {

const std::string kPackage = "/host" TRIBUS_PACKAGE;
const std::string kUnit = "tribus@servos.service";
const std::filesystem::path kConfigurations = "/etc/tribus";
const std::filesystem::path kDropIns = "/run/systemd/system";

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

void install() {
    shell("apt-get -q -y install " + kPackage);
}

void write_file(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

std::string property(const std::string& name, const std::string& unit = kUnit) {
    std::string value = shell("systemctl show -P " + name + " " + unit);
    while (!value.empty() && value.back() == '\n') {
        value.pop_back();
    }
    return value;
}

bool becomes(const std::string& name, const std::string& value, const std::string& unit = kUnit) {
    return in_time([&] { return property(name, unit) == value; });
}

/// Returns the time in the format of journalctl.
std::string now_for_journal() {
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

TEST_F(InstalledPackage, HasAUserGroupsAndDevicesOfItsOwn) {
    EXPECT_NE(shell("id tribus").find("(tribus)"), std::string::npos);
    shell("getent group gpio");
    EXPECT_EQ(shell("udevadm settle; stat -c %G:%a /dev/cpu_dma_latency"), "tribus:660\n");
}

TEST_F(InstalledPackage, HasAProgramThatTakesEveryExample) {
    shell(
        "for file in /usr/share/doc/tribus/examples/*.toml; do tribus check \"$file\" || exit 1; "
        "done");
}

TEST_F(InstalledPackage, HasAUnitThatIsRightAndClosed) {
    EXPECT_EQ(shell("systemd-analyze verify --man=no " + kUnit), "");
    shell("systemd-analyze security --no-pager --threshold=15 " + kUnit);
}

TEST_F(InstalledPackage, IsNotTriedAgainWhereItsConfigurationHasMistakes) {
    write_file(kConfigurations / "servos.toml", "[input.receiver]\nprotocol = \"ibis\"\n");
    EXPECT_NE(run_shell("systemctl start " + kUnit).status, 0);
    EXPECT_TRUE(becomes("ActiveState", "failed"));
    EXPECT_EQ(property("ExecMainStatus"), "2");
    EXPECT_NE(journal("-p err").find("/etc/tribus/servos.toml:2:12: "), std::string::npos)
        << journal();
}

TEST_F(InstalledPackage, WaitsAsLongAsItTakesForADeviceThatIsMissingAtItsStart) {
    unplug_usb(1);
    EXPECT_NE(run_shell("systemctl start " + kUnit).status, 0);
    EXPECT_TRUE(in_time([&] { return std::stoi(property("NRestarts")) >= 3; })) << journal();
    plug_usb(1);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
}

TEST_F(InstalledService, TranslatesIbusToSbus) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, HasAllOfRealTime) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(journal("-p warning").find("no full real time"), std::string::npos) << journal();
}

TEST_F(InstalledService, TellsInItsStatusWhatGoesOn) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(becomes("StatusText", "servos: under control of receiver; receiver: good"));
}

TEST_F(InstalledService, WritesLevelsIntoTheJournal) {
    const std::string started = "started /etc/tribus/servos.toml";
    EXPECT_EQ(journal("-t tribus -p info").rfind(started, 0), 0U) << journal();
    EXPECT_EQ(journal("-p notice").find(started), std::string::npos);
}

TEST_F(InstalledService, TellsTheJournalWhatEachEntryIsAbout) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(in_time([&] {
        return journal("TRIBUS_INPUT=receiver TRIBUS_CAUSE=good") == "input receiver: good\n";
    })) << journal();
    EXPECT_TRUE(in_time([&] {
        return journal("TRIBUS_OUTPUT=servos TRIBUS_STATE=control") ==
               "output servos: under control of receiver\n";
    })) << journal();
}

TEST_F(InstalledService, TranslatesOnAReadOnlyRoot) {
    // As after a disk error, even though programs have files open.
    shell("systemctl stop " + kUnit + "; echo u > /proc/sysrq-trigger");
    EXPECT_TRUE(in_time([] { return run_shell("touch /var/lib/anything").status != 0; }));
    shell("systemctl start " + kUnit);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_NE(run_shell("touch /var/lib/anything").status, 0) << "the root is not read-only";
    shell("mount -o remount,rw /");
}

TEST_F(InstalledService, TranslatesOnAFullDisk) {
    shell("systemctl stop " + kUnit + "; cat /dev/zero > /var/full; true");
    EXPECT_NE(run_shell("head -c 1000000 /dev/zero > /var/more").status, 0)
        << "the disk is not full";
    shell("systemctl start " + kUnit);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("rm /var/full /var/more");
}

TEST_F(InstalledService, GoesBackFromATrialByItself) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    EXPECT_NE(shell("tribus reload servos --trial 2s < /dev/null 2>&1").find("taken, on trial"),
              std::string::npos);
    EXPECT_TRUE(carries(1200, 1800)) << journal();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
}

TEST_F(InstalledService, ComesBackAfterItWasKilled) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s KILL " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1"));
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, ComesBackAfterItsDataThreadHung) {
    restart_with_hang_preload();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s USR2 " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1")) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
    EXPECT_NE(journal("-p err").find("the data thread stands still"), std::string::npos);
}

TEST_F(InstalledService, ComesBackAfterItsMainThreadHung) {
    restart_with_hang_preload();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s USR1 " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1")) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, TakesANewConfigurationWhenItIsReloaded) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    shell("systemctl reload " + kUnit);
    EXPECT_TRUE(carries(1200, 1800)) << journal();
    EXPECT_TRUE(becomes("ActiveState", "active"));
    EXPECT_EQ(property("NRestarts"), "0");
}

TEST_F(InstalledService, GoesOnAfterAReloadThatWasRefused) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { form = 1 }\n");
    shell("systemctl reload " + kUnit);
    EXPECT_TRUE(carries(1800, 1800)) << journal();
    EXPECT_TRUE(becomes("ActiveState", "active"));
    EXPECT_NE(journal("-p err").find("reload refused"), std::string::npos) << journal();
}

TEST_F(InstalledService, LivesOnWhileItsPackageIsUpgraded) {
    const std::string process = property("MainPID");
    const std::string said = shell("dpkg -i " + kPackage);
    EXPECT_NE(said.find("running instances keep the old version"), std::string::npos) << said;
    EXPECT_EQ(property("MainPID"), process);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
}

/// An instance that runs another program, which tries what is forbidden.
class Sandbox : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        install();
        write_file("/home/somebody/secret", "treasure\n");
        shell("chmod -R a+rX /home; mkdir -p /srv/open; chmod 777 /srv/open; chmod 666 /dev/vda");
        write_file("/usr/local/lib/probe.sh",
                   "exec >/run/tribus/probe/tried 2>&1\n"
                   "try() { echo \"$1: $(eval \"$2\" 2>&1 | tr '\\n' ' ')\"; }\n"
                   "try rights \"grep -hE '^(CapPrm|CapBnd|NoNewPrivs|Seccomp):' "
                   "/proc/self/status\"\n"
                   "try home 'cat /home/somebody/secret'\n"
                   "try system 'touch /srv/open/a'\n"
                   "try folder 'touch /run/tribus/probe/a && echo made'\n"
                   "try internet 'exec 3<>/dev/tcp/127.0.0.1/80'\n"
                   "try disk 'head -c 1 /dev/vda'\n"
                   "try namespace 'unshare --user true'\n");
        write_file(kDropIns / "tribus@probe.service.d" / "test.conf",
                   "[Service]\nType=oneshot\nRestart=no\nWatchdogSec=0\n"
                   "RuntimeDirectoryPreserve=yes\nExecStart=\n"
                   "ExecStart=/bin/bash /usr/local/lib/probe.sh\n");
        shell("systemctl daemon-reload; systemctl start tribus@probe.service");
        std::ifstream file("/run/tribus/probe/tried");
        for (std::string line; std::getline(file, line);) {
            const std::size_t colon = line.find(": ");
            tried_[line.substr(0, colon)] = line.substr(colon + 2);
        }
        shell("rm -r /run/tribus");
    }

    static bool says(const std::string& attempt, const std::string& text) {
        return tried_[attempt].find(text) != std::string::npos;
    }

    static inline std::map<std::string, std::string> tried_;
};

TEST_F(Sandbox, HasNoPrivileges) {
    EXPECT_EQ(tried_["rights"],
              "CapPrm:\t0000000000000000 CapBnd:\t0000000000000000 NoNewPrivs:\t1 Seccomp:\t2 ");
}

TEST_F(Sandbox, SeesNothingOfHomes) {
    EXPECT_TRUE(says("home", "cat: ")) << tried_["home"];
    EXPECT_FALSE(says("home", "treasure")) << tried_["home"];
}

TEST_F(Sandbox, WritesNowhereButIntoItsOwnFolder) {
    EXPECT_TRUE(says("system", "Read-only file system")) << tried_["system"];
    EXPECT_EQ(tried_["folder"], "made ");
}

TEST_F(Sandbox, HasNoInternet) {
    EXPECT_TRUE(says("internet", "Address family not supported")) << tried_["internet"];
}

TEST_F(Sandbox, OpensNoDeviceOfAnotherKind) {
    EXPECT_TRUE(says("disk", "Operation not permitted")) << tried_["disk"];
}

TEST_F(Sandbox, MakesNoNamespaces) {
    EXPECT_TRUE(says("namespace", "Operation not permitted")) << tried_["namespace"];
}

class CanExamples : public InstalledPackage {};

TEST_F(CanExamples, BringABusUp) {
    shell(
        "cp /usr/share/doc/tribus/examples/networkd/80-can* /etc/systemd/network/; "
        "rm /etc/systemd/network/80-can0-fd.network; "
        "driver=$(basename $(readlink -f /sys/class/net/can0/device/driver/module)); "
        "modprobe -r $driver; modprobe $driver; systemctl start systemd-networkd");
    EXPECT_TRUE(in_time([] {
        return shell("ip -details link show can0").find("bitrate 500000") != std::string::npos;
    })) << shell("ip -details link show can0; journalctl -q -u systemd-networkd");
    const std::string link = shell("ip -details link show can0");
    EXPECT_NE(link.find("restart-ms 100"), std::string::npos) << link;
    EXPECT_NE(link.find("qlen 16"), std::string::npos) << link;
    EXPECT_TRUE(in_time([] {
        return shell("ip link show can0").find(",UP,") != std::string::npos;
    })) << shell("ip link show can0");
}

/// This test is the last one, because it removes the package.
class RemovedPackage : public InstalledPackage {};

TEST_F(RemovedPackage, HasStoppedAndLeavesNothingButConfigurationsOfItsOwner) {
    shell("systemctl enable --now " + kUnit);
    shell("apt-get -q -y remove tribus");
    EXPECT_EQ(shell("pgrep tribus || true"), "");
    EXPECT_NE(shell("systemctl is-enabled " + kUnit + " 2>&1 || true"), "enabled\n");
    shell("apt-get -q -y purge tribus");
    EXPECT_EQ(shell("find / -xdev -name '*tribus*' -not -path '/var/cache/*' "
                    "-not -path '/host/*' -not -path '/var/log/*' | sort"),
              "/etc/tribus\n");
    EXPECT_EQ(shell("ls /etc/tribus"), "servos.toml\n");
    // As with other packages: the number of a removed user must not be given to another user.
    shell("id tribus");
}

}  // namespace
}  // namespace tribus::test::systemd_service_test

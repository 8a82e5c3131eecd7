#include "app/recorder/recording_job.h"

#include <cstddef>
#include <cstring>
#include <exception>
#include <utility>

#include "transports/links/start_thread.h"

namespace tribus {
namespace {

/// A stack of the usual 8 MB would count as locked memory.
constexpr std::size_t kStackBytes = std::size_t{256} * 1024;

}  // namespace

RecordingJob::Result RecordingJob::write() {
    if (prepare_) {
        prepared_ = false;
        auto work = prepare_();
        if (!work) {
            return tl::unexpected(work.error());
        }
        work_ = std::move(*work);
        prepared_ = true;
        for (std::size_t i = 0; i < work_.rings.size(); ++i) {
            work_.order.ports[i].ring = &work_.rings[i];
        }
    }
    return write_recording(work_.order);
}

void* RecordingJob::main(void* self) {
    auto& job = *static_cast<RecordingJob*>(self);
    ::pthread_setname_np(::pthread_self(), "tribus-recorder");
    // A file that a crash left may be damaged, and ask for more memory than there is.
    try {
        job.result_ = job.write();
    } catch (const std::exception& error) {
        job.result_ = tl::unexpected<std::string>(error.what());
    }
    job.done_.store(true, std::memory_order_release);
    return nullptr;
}

std::unique_ptr<RecordingJob> RecordingJob::start(RecordingOrder order) {
    std::unique_ptr<RecordingJob> job(new RecordingJob);
    job->work_.order = std::move(order);
    job->start_thread();
    return job;
}

std::unique_ptr<RecordingJob> RecordingJob::start(Prepare prepare) {
    std::unique_ptr<RecordingJob> job(new RecordingJob);
    job->prepare_ = std::move(prepare);
    job->start_thread();
    return job;
}

void RecordingJob::start_thread() {
    const int error = tribus::start_thread(thread_, kStackBytes, &RecordingJob::main, this);
    started_ = error == 0;
    if (error != 0) {
        result_ = tl::unexpected(std::string("cannot create a thread: ") + std::strerror(error));
        done_ = true;
    }
}

RecordingJob::~RecordingJob() {
    if (started_) {
        ::pthread_join(thread_, nullptr);
    }
}

}  // namespace tribus

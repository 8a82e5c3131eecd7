#include "app/recorder/recording_job.h"

#include <cstring>
#include <utility>

namespace tribus {
namespace {

/// A stack of the usual 8 MB would count as locked memory.
constexpr std::size_t kStackBytes = std::size_t{256} * 1024;

}  // namespace

void* RecordingJob::main(void* self) {
    auto& job = *static_cast<RecordingJob*>(self);
    ::pthread_setname_np(::pthread_self(), "tribus-recorder");
    job.result_ = write_recording(job.order_);
    job.done_.store(true, std::memory_order_release);
    return nullptr;
}

std::unique_ptr<RecordingJob> RecordingJob::start(RecordingOrder order,
                                                  std::vector<RingMemory> kept,
                                                  std::vector<CaptureRing> rings) {
    std::unique_ptr<RecordingJob> job(new RecordingJob);
    job->order_ = std::move(order);
    job->kept_ = std::move(kept);
    job->rings_ = std::move(rings);
    for (std::size_t i = 0; i < job->rings_.size(); ++i) {
        job->order_.ports[i].ring = &job->rings_[i];
    }
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, kStackBytes);
    const int error = ::pthread_create(&job->thread_, &attributes, &RecordingJob::main, job.get());
    ::pthread_attr_destroy(&attributes);
    job->started_ = error == 0;
    if (error != 0) {
        job->result_ =
            tl::unexpected(std::string("cannot create a thread: ") + std::strerror(error));
        job->done_ = true;
    }
    return job;
}

RecordingJob::~RecordingJob() {
    if (started_) {
        ::pthread_join(thread_, nullptr);
    }
}

}  // namespace tribus

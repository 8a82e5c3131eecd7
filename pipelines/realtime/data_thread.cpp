#include "pipelines/realtime/data_thread.h"

#include <malloc.h>

#include <cstring>
#include <utility>

#include "transports/links/start_thread.h"

namespace tribus {

DataThread::~DataThread() {
    if (!started_) {
        return;
    }
    if (!released_) {
        cancelled_ = true;
        run();
    }
    loop_->request_end();
    join();
}

void* DataThread::main(void* self) {
    auto& thread = *static_cast<DataThread*>(self);
    unblock_sigcont();
    thread.got_ = make_realtime(thread.scheduling_);
    thread.prepared_.release();
    thread.go_.acquire();
    if (thread.cancelled_) {
        return nullptr;
    }
    Loop* loop = thread.loop_;
    while (Loop* next = loop->run()) {
        loop = next;
        thread.handed_over_.release();
    }
    if (loop->failure() != 0) {
        thread.failure_.store(loop->failure(), std::memory_order_release);
        thread.handed_over_.release();
    }
    return nullptr;
}

tl::expected<std::vector<std::string>, std::string> DataThread::prepare() {
    // The data thread does not allocate once it runs, so it needs no heap of its own.
    ::mallopt(M_ARENA_MAX, 1);
    const int error = start_thread(thread_, kRealtimeStackBytes, &DataThread::main, this);
    if (error != 0) {
        return tl::unexpected(std::string("cannot start the data thread: ") + std::strerror(error));
    }
    started_ = true;
    prepared_.acquire();
    return got_.missing;
}

void DataThread::run() {
    released_ = true;
    go_.release();
}

void DataThread::hand_over_to(Loop& next, LoopCarry carry) {
    loop_->hand_over_to(next, std::move(carry));
    handed_over_.acquire();
    loop_ = &next;
}

std::string DataThread::failure() const {
    const int error = failure_.load(std::memory_order_acquire);
    return error == 0
               ? std::string()
               : std::string("the data thread cannot wait for its ports: ") + std::strerror(error) +
                     "; a filter of system calls must allow ppoll and epoll_pwait";
}

void DataThread::join() {
    if (started_) {
        ::pthread_join(thread_, nullptr);
        started_ = false;
    }
}

}  // namespace tribus

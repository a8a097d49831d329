#include "pool.h"

#include "thread.h"
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* A thread looks for the next job this long before it sleeps. The calls of a loop follow one another within some
 * 10 us, and waking a thread takes up to 100 us. The time is that of a clock, because a pause takes 10 to 150 cycles,
 * depending on the processor. */
#define LOOKING_TIME 100e-6 /* s */
enum { LOOKS_PER_CLOCK = 32 };
/* The caller gives its processor to another thread after this many looks for the end of the last pieces. */
enum { LOOKS_BEFORE_YIELD = 200 };
/* The share of a thread has this many pieces, so that none waits long for one with slow instances. */
enum { PIECES_OF_SHARE = 16 };
/* A smaller job costs less than handing it over. */
enum { LEAST_WORK = 64 };

/* A ticket is the number of a job in the upper half, and the next piece of a share of this job in the lower half. */
#define PIECE_BITS 32
#define NO_PIECE UINT32_MAX
/* Bytes: two cache lines, since processors fetch lines in pairs. */
enum { APART = 128 };

/* Pieces of consecutive instances. Each thread begins with its own share, which is the same in each job, so that these
 * instances stay in the cache of its processor. Then the thread helps with the shares of the others. */
typedef struct {
    _Atomic uint64_t ticket;
    atomic_uint end; /* behind the last piece */
    char apart[APART];
} Share;

typedef struct {
    Pool *pool;
    unsigned number;
    Thread *thread;
} Worker;

struct Pool {
    unsigned long process; /* that has the threads */
    unsigned threads;
    Worker *workers; /* [threads - 1] */
    Share *shares;   /* [threads] */
    Monitor *monitor;
    atomic_bool ends;
    atomic_uint sleepers;
    /* the present job: written only while all tickets have NO_PIECE */
    PoolJob *job;
    void *context;
    size_t count, piece;
    atomic_uint done; /* pieces */
};

static uint64_t ticket_of(uint32_t job, uint32_t piece) {
    return (uint64_t)job << PIECE_BITS | piece;
}

static uint32_t job_of(uint64_t ticket) {
    return (uint32_t)(ticket >> PIECE_BITS);
}

/* Takes the next piece of a share of the present job. A thread that comes late, with the ticket of an earlier job,
 * takes none: the exchange fails. */
static bool take_piece(Share *share, uint32_t *piece) {
    uint64_t ticket = atomic_load(&share->ticket);
    for (;;) {
        *piece = (uint32_t)ticket;
        if (*piece == NO_PIECE || *piece >= atomic_load(&share->end)) return false;
        if (atomic_compare_exchange_weak(&share->ticket, &ticket, ticket + 1)) return true;
    }
}

/* The number of pieces done. */
static unsigned work_on_share(const Pool *pool, Share *share, unsigned worker) {
    unsigned done = 0;
    for (uint32_t piece; take_piece(share, &piece); done++) {
        size_t first = piece * pool->piece, rest = pool->count - first;
        pool->job(pool->context, first, first + (rest < pool->piece ? rest : pool->piece), worker);
    }
    return done;
}

/* The pieces of a share are booked at once: a number that several threads write is slow. */
static void work(Pool *pool, unsigned worker) {
    for (unsigned i = 0; i < pool->threads; i++) {
        unsigned done = work_on_share(pool, &pool->shares[(worker + i) % pool->threads], worker);
        if (done > 0) atomic_fetch_add(&pool->done, done);
    }
}

/* Looks for a job with another number than `seen`, for LOOKING_TIME. */
static bool look_for_job(const Share *share, uint32_t seen) {
    double begin = thread_clock();
    do {
        for (int look = 0; look < LOOKS_PER_CLOCK; look++) {
            if (job_of(atomic_load_explicit(&share->ticket, memory_order_relaxed)) != seen) return true;
            thread_pause();
        }
    } while (thread_clock() - begin < LOOKING_TIME);
    return false;
}

/* Waits until the number of the job is no longer `seen`; returns the new number. */
static uint32_t await_job(Pool *pool, const Share *share, uint32_t seen) {
    if (!look_for_job(share, seen)) {
        monitor_lock(pool->monitor);
        atomic_fetch_add(&pool->sleepers, 1);
        while (job_of(atomic_load(&share->ticket)) == seen) monitor_sleep(pool->monitor);
        atomic_fetch_sub(&pool->sleepers, 1);
        monitor_unlock(pool->monitor);
    }
    return job_of(atomic_load(&share->ticket));
}

static void run_worker(void *argument) {
    const Worker *worker = argument;
    Pool *pool = worker->pool;
    for (uint32_t seen = 0;;) {
        seen = await_job(pool, &pool->shares[worker->number], seen);
        if (atomic_load(&pool->ends)) return;
        work(pool, worker->number);
    }
}

static uint32_t present_job(const Pool *pool) {
    return job_of(atomic_load(&pool->shares[0].ticket));
}

/* From here on no late thread takes a piece. */
static void withdraw_pieces(Pool *pool) {
    uint32_t job = present_job(pool);
    for (unsigned i = 0; i < pool->threads; i++) atomic_store(&pool->shares[i].ticket, ticket_of(job, NO_PIECE));
}

/* Lets the threads see the next job, or that the pool ends, where `pieces` is 0. */
static void announce(Pool *pool, uint32_t pieces) {
    uint32_t job = present_job(pool) + 1, first = 0;
    for (unsigned i = 0; i < pool->threads; i++) {
        uint32_t end = (uint32_t)((uint64_t)pieces * (i + 1) / pool->threads);
        atomic_store(&pool->shares[i].end, end);
        atomic_store(&pool->shares[i].ticket, ticket_of(job, first));
        first = end;
    }
    if (atomic_load(&pool->sleepers) == 0) return;
    monitor_lock(pool->monitor);
    monitor_wake(pool->monitor);
    monitor_unlock(pool->monitor);
}

static bool start_workers(Pool *pool) {
    for (unsigned i = 0; i + 1 < pool->threads; i++) {
        Worker *worker = &pool->workers[i];
        *worker = (Worker){.pool = pool, .number = i + 1};
        worker->thread = thread_start(run_worker, worker);
        if (worker->thread == NULL) {
            pool->threads = i + 1; /* those that did start */
            return false;
        }
    }
    return true;
}

static Share *new_shares(unsigned threads) {
    Share *shares = calloc(threads, sizeof *shares);
    for (unsigned i = 0; shares != NULL && i < threads; i++) atomic_store(&shares[i].ticket, ticket_of(0, NO_PIECE));
    return shares;
}

Pool *pool_new(unsigned threads) {
    Pool *pool = threads > 0 ? calloc(1, sizeof *pool) : NULL;
    if (pool == NULL) return NULL;
    pool->process = thread_process();
    pool->threads = threads;
    pool->monitor = monitor_new();
    pool->workers = calloc(threads, sizeof *pool->workers);
    pool->shares = new_shares(threads);
    bool has_all = pool->monitor != NULL && pool->workers != NULL && pool->shares != NULL;
    if (!has_all) pool->threads = 1;
    if (has_all && start_workers(pool)) return pool;
    pool_free(pool);
    return NULL;
}

void pool_free(Pool *pool) {
    if (pool == NULL) return;
    if (pool->threads > 1) {
        atomic_store(&pool->ends, true);
        withdraw_pieces(pool);
        announce(pool, 0);
        for (unsigned i = 0; i + 1 < pool->threads; i++) thread_join(pool->workers[i].thread);
    }
    monitor_free(pool->monitor);
    free(pool->shares);
    free(pool->workers);
    free(pool);
}

static void await_end(Pool *pool, uint32_t pieces) {
    for (int look = 0; atomic_load(&pool->done) < pieces; look++) {
        if (look < LOOKS_BEFORE_YIELD) thread_pause();
        else thread_yield();
    }
}

/* Whether the threads take part in a job. */
static bool is_shared(const Pool *pool, size_t work) {
    return pool->threads > 1 && work > LEAST_WORK && pool->process == thread_process();
}

void pool_run(Pool *pool, PoolJob *job, void *context, size_t count, size_t work_of_one) {
    if (!is_shared(pool, count * work_of_one)) {
        job(context, 0, count, 0);
        return;
    }
    withdraw_pieces(pool);
    size_t most = (size_t)pool->threads * PIECES_OF_SHARE;
    pool->job = job;
    pool->context = context;
    pool->count = count;
    pool->piece = (count + most - 1) / most;
    uint32_t pieces = (uint32_t)((count + pool->piece - 1) / pool->piece);
    atomic_store(&pool->done, 0);
    announce(pool, pieces);
    work(pool, 0);
    await_end(pool, pieces);
}

#include "fleet/pool.h"

#include "fleet/thread.h"
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* A thread looks for the next job this often before it sleeps, about 50 us at 3 GHz. The calls of a loop follow one
 * another within some 10 us, and waking a thread takes about as long. */
enum { LOOKS_BEFORE_SLEEP = 2000 };
/* The caller gives its processor to another thread after this many looks for the end of the last pieces. */
enum { LOOKS_BEFORE_YIELD = 200 };
/* A job has this many pieces for each thread, so that none waits long for one with slow instances. */
enum { PIECES_PER_THREAD = 8 };
/* A smaller job costs less than handing it over. */
enum { LEAST_WORK = 64 };

/* A ticket is the number of a job in the upper half, and the next piece of this job in the lower half. */
#define PIECE_BITS 32
#define NO_PIECE UINT32_MAX

typedef struct {
    Pool *pool;
    unsigned number;
    Thread *thread;
} Worker;

struct Pool {
    unsigned threads;
    Worker *workers; /* [threads - 1] */
    Monitor *monitor;
    atomic_bool ends;
    atomic_uint sleepers;
    /* the present job: written only while the ticket has NO_PIECE */
    PoolJob *job;
    void *context;
    size_t count, piece;
    atomic_uint pieces;
    atomic_uint done; /* pieces */
    _Atomic uint64_t ticket;
};

static uint64_t ticket_of(uint32_t job, uint32_t piece) {
    return (uint64_t)job << PIECE_BITS | piece;
}

static uint32_t job_of(uint64_t ticket) {
    return (uint32_t)(ticket >> PIECE_BITS);
}

/* Takes the next piece of the present job. A thread that comes late, with the ticket of an earlier job, takes none:
 * the exchange fails. */
static bool take_piece(Pool *pool, uint32_t *piece) {
    uint64_t ticket = atomic_load(&pool->ticket);
    for (;;) {
        *piece = (uint32_t)ticket;
        if (*piece == NO_PIECE || *piece >= atomic_load(&pool->pieces)) return false;
        if (atomic_compare_exchange_weak(&pool->ticket, &ticket, ticket + 1)) return true;
    }
}

static void work(Pool *pool, unsigned worker) {
    uint32_t piece;
    while (take_piece(pool, &piece)) {
        size_t first = piece * pool->piece, rest = pool->count - first;
        pool->job(pool->context, first, first + (rest < pool->piece ? rest : pool->piece), worker);
        atomic_fetch_add(&pool->done, 1);
    }
}

/* Waits until the number of the job is no longer `seen`; returns the new number. */
static uint32_t await_job(Pool *pool, uint32_t seen) {
    for (int look = 0; look < LOOKS_BEFORE_SLEEP; look++) {
        uint32_t job = job_of(atomic_load_explicit(&pool->ticket, memory_order_relaxed));
        if (job != seen) return job;
        thread_pause();
    }
    monitor_lock(pool->monitor);
    atomic_fetch_add(&pool->sleepers, 1);
    while (job_of(atomic_load(&pool->ticket)) == seen) monitor_sleep(pool->monitor);
    atomic_fetch_sub(&pool->sleepers, 1);
    monitor_unlock(pool->monitor);
    return job_of(atomic_load(&pool->ticket));
}

static void run_worker(void *argument) {
    const Worker *worker = argument;
    Pool *pool = worker->pool;
    for (uint32_t seen = 0;;) {
        seen = await_job(pool, seen);
        if (atomic_load(&pool->ends)) return;
        work(pool, worker->number);
    }
}

/* Lets the threads see the job. */
static void announce(Pool *pool, uint32_t job, uint32_t first_piece) {
    atomic_store(&pool->ticket, ticket_of(job, first_piece));
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

Pool *pool_new(unsigned threads) {
    Pool *pool = calloc(1, sizeof *pool);
    if (pool == NULL) return NULL;
    pool->threads = threads;
    pool->monitor = monitor_new();
    pool->workers = calloc(threads, sizeof *pool->workers);
    atomic_store(&pool->ticket, ticket_of(0, NO_PIECE));
    bool has_all = pool->monitor != NULL && pool->workers != NULL;
    if (!has_all) pool->threads = 1;
    if (has_all && start_workers(pool)) return pool;
    pool_free(pool);
    return NULL;
}

void pool_free(Pool *pool) {
    if (pool == NULL) return;
    if (pool->threads > 1) {
        atomic_store(&pool->ends, true);
        announce(pool, job_of(atomic_load(&pool->ticket)) + 1, NO_PIECE);
        for (unsigned i = 0; i + 1 < pool->threads; i++) thread_join(pool->workers[i].thread);
    }
    monitor_free(pool->monitor);
    free(pool->workers);
    free(pool);
}

static void await_end(Pool *pool) {
    unsigned pieces = atomic_load(&pool->pieces);
    for (int look = 0; atomic_load(&pool->done) < pieces; look++) {
        if (look < LOOKS_BEFORE_YIELD) thread_pause();
        else thread_yield();
    }
}

void pool_run(Pool *pool, PoolJob *job, void *context, size_t count, size_t work_of_one) {
    if (pool->threads == 1 || count * work_of_one <= LEAST_WORK) {
        job(context, 0, count, 0);
        return;
    }
    uint32_t number = job_of(atomic_load(&pool->ticket));
    atomic_store(&pool->ticket, ticket_of(number, NO_PIECE)); /* from here on no late thread takes a piece */
    size_t most = (size_t)pool->threads * PIECES_PER_THREAD;
    pool->job = job;
    pool->context = context;
    pool->count = count;
    pool->piece = (count + most - 1) / most;
    atomic_store(&pool->pieces, (unsigned)((count + pool->piece - 1) / pool->piece));
    atomic_store(&pool->done, 0);
    announce(pool, number + 1, 0);
    work(pool, 0);
    await_end(pool);
}

#include "fleet/pool.h"

#include "fleet/thread.h"
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* Waiting: a thread looks for the next job this often before it sleeps. Waking a thread takes longer than a step of a
 * fleet of 1000, and calls of a loop follow one another within some 10 us. About 50 us at 3 GHz. */
enum { LOOKS_BEFORE_SLEEP = 2000 };
/* A thread takes this many pieces of a job, so that none waits long for one with slow instances. */
enum { PIECES_PER_THREAD = 8, LEAST_PIECE = 16 };

typedef struct {
    Pool *pool;
    unsigned number;
    Thread *thread;
} Worker;

struct Pool {
    unsigned threads;
    Worker *workers; /* [threads - 1] */
    Monitor *monitor;
    /* the present job */
    PoolJob *job;
    void *context;
    size_t count, piece;
    atomic_size_t next;
    atomic_uint unfinished; /* workers that have not left the job yet */
    atomic_uint jobs;       /* number of jobs so far; a change begins one */
    atomic_bool ends;
};

static void work(Pool *pool, unsigned worker) {
    for (;;) {
        size_t first = atomic_fetch_add_explicit(&pool->next, pool->piece, memory_order_relaxed);
        if (first >= pool->count) return;
        size_t rest = pool->count - first;
        pool->job(pool->context, first, first + (rest < pool->piece ? rest : pool->piece), worker);
    }
}

/* Waits until the number of jobs is no longer `seen`. */
static void await_job(Pool *pool, unsigned seen) {
    for (int look = 0; look < LOOKS_BEFORE_SLEEP; look++) {
        if (atomic_load_explicit(&pool->jobs, memory_order_acquire) != seen) return;
        thread_pause();
    }
    monitor_lock(pool->monitor);
    while (atomic_load_explicit(&pool->jobs, memory_order_acquire) == seen) monitor_sleep(pool->monitor);
    monitor_unlock(pool->monitor);
}

static void run_worker(void *argument) {
    Worker *worker = argument;
    Pool *pool = worker->pool;
    for (unsigned seen = 0;; seen++) {
        await_job(pool, seen);
        if (atomic_load_explicit(&pool->ends, memory_order_relaxed)) return;
        work(pool, worker->number);
        atomic_fetch_sub_explicit(&pool->unfinished, 1, memory_order_release);
    }
}

static void begin_job(Pool *pool) {
    monitor_lock(pool->monitor);
    atomic_fetch_add_explicit(&pool->jobs, 1, memory_order_release);
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
    if (pool->monitor == NULL || pool->workers == NULL) pool->threads = 1;
    if (pool->monitor != NULL && pool->workers != NULL && start_workers(pool)) return pool;
    pool_free(pool);
    return NULL;
}

void pool_free(Pool *pool) {
    if (pool == NULL) return;
    if (pool->threads > 1) {
        atomic_store_explicit(&pool->ends, true, memory_order_relaxed);
        begin_job(pool);
        for (unsigned i = 0; i + 1 < pool->threads; i++) thread_join(pool->workers[i].thread);
    }
    monitor_free(pool->monitor);
    free(pool->workers);
    free(pool);
}

static size_t piece_of(const Pool *pool, size_t count) {
    size_t piece = count / ((size_t)pool->threads * PIECES_PER_THREAD);
    return piece < LEAST_PIECE ? LEAST_PIECE : piece;
}

void pool_run(Pool *pool, PoolJob *job, void *context, size_t count) {
    if (pool->threads == 1 || count <= LEAST_PIECE) {
        job(context, 0, count, 0);
        return;
    }
    pool->job = job;
    pool->context = context;
    pool->count = count;
    pool->piece = piece_of(pool, count);
    atomic_store_explicit(&pool->next, 0, memory_order_relaxed);
    atomic_store_explicit(&pool->unfinished, pool->threads - 1, memory_order_relaxed);
    begin_job(pool);
    work(pool, 0);
    while (atomic_load_explicit(&pool->unfinished, memory_order_acquire) > 0) thread_pause();
}
